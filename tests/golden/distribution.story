world kitchen
length 15
maximize sum_t P(G_robot | script[:t])
maximize depict(rho)
