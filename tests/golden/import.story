import nothing_like_that
import "patterns.story"
import kitchn
world kitchen
length 15
maximize depict(rho > 0)
