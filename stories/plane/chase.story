# A wolf chases a sheep, and the sheep flees: both are plain to see.
world meadow
length 120

maximize depict(G_wolf = approach and G_sheep = avoid)
minimize sum_t 0.02 * ([acceleration(wolf) @ script[t]] + [acceleration(sheep) @ script[t]])
maximize 0.2 * sum_t ([speed(wolf) @ script[t]] + [speed(sheep) @ script[t]])

# They run all the time as it is.
liveliness 0

# expect mean_t P(G_wolf = approach and G_sheep = avoid | script[:t]) >= 0.85
# expect sum_t [speed(sheep) @ script[t]] >= 6
# expect assume nothing: mean_t P(R_wolf and R_sheep | script[:t]) >= 0.9
