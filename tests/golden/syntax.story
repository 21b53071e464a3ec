world kitchen
length 15
maximize sum_t P(rho == 0 | script[:t])
maximize sum_t P(rho > 0 && rho < 3 | script[:t])
maximize sum_t P(rho > 0 || rho < 3 | script[:t])
maximize sum_t P[rho > 0 | script[:t]]
maximize sum_t E(V(robot) | script[:t])
maximize sum_t P(rho ≥ 0 | script[:t])
maximize sum_t P(rho > 0, script[:t])
maximize sum_t p(rho > 0 | script[:t])
maximize sum_t P(rho > 0 given script[:t])
maximize sum_t KL(script[:t-1], script[:t])
maximize sum_t KL(rho, script[:t-1] || script[:t])
maximize sum_t P(rho > 0 | script[1:t])
maximize P(rho > 0 | script ++ [cheese: stay, robot: east][:T+1])
