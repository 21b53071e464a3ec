world kitchen
length 5
import damaged_golden
import later_golden
maximize dark(rho > 0)
