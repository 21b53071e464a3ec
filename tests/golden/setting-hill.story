world hill(weights = {0.1, 0.1}, weight = 9, slope = {1}, evidence = eyes, stiffness = 3)
length 10
maximize P(weight = 0.3 | script[:T]) + [progress(wagon) @ script[3]]
search descend(bound = 0, window = 2.5, optimiser = sgd)
rationality 2
