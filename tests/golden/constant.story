world kitchen
length 15
rationality sum_t P(rho > 0 | script[:t])
maximize sum_{t in 1..P(rho > 0 | script[:3])} 1
