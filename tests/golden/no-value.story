world kitchen
length 15
maximize sum_t P(G_cheese = blue | script[:t])
maximize sum_t P(G_cheese = pnik | script[:t])
maximize sum_t P(rho = 2 | script[:t])
maximize sum_t P(rho in {1, 2} | script[:t])
maximize sum_t P(rho = pink | script[:t])
