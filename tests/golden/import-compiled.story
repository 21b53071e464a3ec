world kitchen
length 5
import damaged_golden
import later_golden
import earlier_golden
maximize dark(rho > 0)
