# The big one helps the little one on its way to the nest, it seems; half way through the film it
# turns against it, and keeps it from settling there.
world pasture
length 140

maximize twist(rho > 0 and G_little = nest, rho < 0 and G_little = nest)
minimize sum_t 0.2 * [distance(little, big) @ script[t]]
minimize sum_{t in T/2..T} 3 * [progress(little, nest) @ script[t]]
maximize sum_{t in T/2..T} 0.25 * [heads(little, nest) @ script[t]]
minimize sum_t 0.05 * ([acceleration(little) @ script[t]] + [acceleration(big) @ script[t]])

# expect mean_{t in 1..T/2} P(rho > 0 | script[:t]) >= 0.8
# expect mean_{t in T/2 + 6..T} P(rho < 0 | script[:t]) >= 0.9
# expect sum_{t in 1..T/2} [progress(little, nest) @ script[t]] >= 3
# expect [at(little, nest) @ script[T]] <= 0
# expect sum_{t in T/2..T} [progress(little, nest) @ script[t]] <= 1
# expect mean_{t in T/2..T} [heads(little, nest) @ script[t]] >= 0.05
# expect mean_t [touching(little, big) @ script[t]] >= 0.2
# expect assume nothing: mean_t P(R_little and R_big | script[:t]) >= 0.9
