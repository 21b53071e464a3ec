world kitchen(1, gama = 3, level0 = foo, gamma = 1, beta = many)
length 15
search beam(starts = 0, width = 1.5)
audience bayesian(betta = 2)
maximize 1
