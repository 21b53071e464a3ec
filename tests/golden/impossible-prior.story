world kitchen
length 15
audience average(bayesian, bayesian(prior = if rho > 0 then 0 else 1))
maximize sum_t P(G_cheese = pink | script[:t], rho = 1)
maximize irony(G_cheese = green, rho > 0, rho > 0, rho < 0)
assume R_robot and rho > 0
