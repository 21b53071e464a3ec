world hill
length 10
maximize depict(weight = 0.5)
search descend(bound = 1, rate = 0.1, optimiser = ncg, steps = 4)
