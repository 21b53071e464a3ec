world kitchen
length 5
audience insider = bayesian(given = G_cheese = pink)
audience insider = bayesian
audience rho = bayesian
audience t = bayesian
audience twins = bayesian(given = G_cheese = pink and G_cheese = green)
audience doubter = bayesian(given = not R_robot)
audience late = bayesian(given = P(rho > 0 | script[:2]) > 0.5, given = 1 = 1)
let friend = 3
audience friend = bayesian
pattern plain(who, event) = sum_t P[who](event | script[:t])
pattern unused(event) = sum_t P[insidr](event | script[:t])

maximize sum_t P[insidr](rho > 0 | script[:t])
maximize plain(insider, G_cheese = pink)
maximize plain(outsider, rho > 0)
maximize plain(rho > 0, rho < 0)
maximize sum_t P[insider](rho > 0 | script[:t], G_cheese = green)
maximize sum_t E[insider][V(robot)]
maximize sum_t script[t | rho > 0]
maximize plane(insider, rho > 0)
minimize sum_t KL[insider](script[:t-1] || script[:t]) * entropy[viewers](script[:t])
maximize sum_t P[doubter](G_cheese = pink | script[:t])
