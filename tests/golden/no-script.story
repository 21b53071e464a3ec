world kitchen
length 15
maximize sum_t P(rho > 0)
maximize sum_t E[rho]
maximize sum_t P(script[:t])
maximize sum_t P(rho > 0 | rho < 3)
maximize sum_t P(rho > 0 | script[:t], script[:t-1])
maximize sum_t entropy(rho)
maximize sum_t suspense(rho)
