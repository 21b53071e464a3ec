world kitchen
length 15
maximize sum_t P(rho > 0 | script[:t], not R_robot)
maximize sum_t P(rho > 0 | script[:t], rho > 1, rho < 0)
maximize sum_t P(rho > 0 | script[:t], G_cheese != pink and G_cheese != green)
maximize sum_t E[V(robot) | script[:t], rho > 3]
