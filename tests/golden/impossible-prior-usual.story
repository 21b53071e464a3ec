world kitchen
length 15
audience bayesian(prior = if R_cheese then 0 else 1)
maximize depict(rho > 0)
