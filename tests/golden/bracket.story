world kitchen
length 15
maximize sum_t P(rho > 0 | script[:t)
maximize (sum_t P(rho > 0 | script[:t])
maximize sum_t P(rho > 0 | script[:t]))
