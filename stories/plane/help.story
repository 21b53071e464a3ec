# The big one helps the little one to where it wants to be: it pushes from behind.
world pasture
length 100

maximize depict(rho > 0)
minimize sum_t 0.3 * [distance(little, big) @ script[t]]
minimize sum_t 0.05 * ([acceleration(little) @ script[t]] + [acceleration(big) @ script[t]])
maximize 20 * [at(little, nest) @ script[T]]

# expect mean_t P(rho > 0 | script[:t]) >= 0.85
# expect [at(little, nest) @ script[T]] >= 1
# expect mean_t [touching(little, big) @ script[t]] >= 0.3
# expect assume nothing: mean_t P(R_little and R_big | script[:t]) >= 0.9
