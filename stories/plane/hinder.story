# The little one wants to go to its nest, and the big one keeps it away: it presses against
# it until it stands still, and pushes it back.
world pasture
length 100

maximize depict(rho < 0 and G_little = nest)
minimize sum_t 0.3 * [distance(little, big) @ script[t]]
minimize sum_t 3 * [progress(little, nest) @ script[t]]
maximize sum_t 0.25 * [heads(little, nest) @ script[t]]
minimize sum_t 0.05 * ([acceleration(little) @ script[t]] + [acceleration(big) @ script[t]])

# expect mean_t P(rho < 0 and G_little = nest | script[:t]) >= 0.8
# expect mean_t [touching(little, big) @ script[t]] >= 0.3
# expect sum_t [progress(little, nest) @ script[t]] <= 4
# expect mean_t [heads(little, nest) @ script[t]] >= 0.25
# expect assume nothing: mean_t P(R_little and R_big | script[:t]) >= 0.9
