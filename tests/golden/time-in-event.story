world kitchen
length 15
maximize sum_t P(rho > t | script[:t])
