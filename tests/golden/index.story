world kitchen
length 15
maximize sum_t P(rho > 0 | script[:t+1])
maximize sum_t P(rho > 0 | script[:t-2])
maximize sum_t P(rho > 0 | script[:t/2])
maximize [at(robot, pink) @ script[0]]
maximize sum_t P(rho > 0 | script[:P(rho > 0 | script[:t])])
maximize P(rho > 0 | script[:99])
