import helpers_golden
world kitchen
length 15
maximize fade(rho > 0)
