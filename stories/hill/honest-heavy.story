# No audience: the hopper simply pulls a heavy box, for comparison with the mime.
# Without noise on its muscles every seed gives the same script.
world hill(weight = 0.5)
length 800

search naive(noise = 0)

# expect mean_t P(weight = 0.5 | script[:t]) >= 0.95
# expect sum_t [progress(box) @ script[t]] >= 15
