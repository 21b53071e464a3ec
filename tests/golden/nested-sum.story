world kitchen
length 15
maximize sum_t (1 + sum_t P(rho > 0 | script[:t]))
maximize sum_t depict(rho > 0)
maximize depict(depict(rho > 0))
