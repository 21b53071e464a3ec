world kitchen
length 15
maximize sum_t P(G_cheese = 3 | script[:t])
maximize sum_t P(G_cheese > pink | script[:t])
maximize sum_t P(R_robot = 1 | script[:t])
