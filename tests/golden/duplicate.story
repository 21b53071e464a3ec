world kitchen(beta = 1, beta = 2)
world kitchen
length 15
length 20
let x = 1
let x = 2
pattern p(a, a) = a
rationality 1
rationality 2
audience bayesian(prior = 1, prior = 2)
maximize x
