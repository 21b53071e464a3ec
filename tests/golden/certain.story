world kitchen
length 15
maximize sum_t P(R_robot | script[:t])
maximize sum_t P(rho > 0 | script[:t], rho = 1)
maximize depict(R_cheese)
