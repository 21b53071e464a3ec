world kitchen
length 15
maximize depict(rho > 0)
audience average(bayesian(beta = 1), 3, baysian, bayesian(prior = rho))
