world kitchen
length 5
maximize sum_t P[insider](rho > 0 | script[:t])
