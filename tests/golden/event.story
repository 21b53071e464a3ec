world kitchen
length 15
maximize sum_t P([at(robot, pink) @ script[t]] > 0 | script[:t])
maximize sum_t P(P(rho > 0 | script[:t]) > 0.5 | script[:t])
maximize sum_t E[P(rho > 0 | script[:t]) | script[:t]]
