world kitchen
length 15
maximize P(rho > 0 | script[:t])
maximize sum_t P(rho > 0 | script[:t]) + KL(script[:t-1] || script[:t])
maximize points((0, 0), (1, 1))
