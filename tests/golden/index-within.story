world kitchen
length 15
maximize sum_t suspense(rho | script[:t, cheese])
maximize sum_t E[V(robot) | script[:t, cheese]]
maximize sum_t P(rho > 0 | script[:t, table])
maximize sum_{t in 0..T} P(rho > 0 | script[:t, cheese])
maximize P(rho > 0 | script[:T, rho > 0])
