world hill
length 10
start fallen(hopper)
maximize depict(weight = 0.5)
search beam(width = 3)
audience bayesian(sigma = {1, 2})
