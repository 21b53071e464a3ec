# The little one is about to go into the house, and the big one drives it away; it slips past, and
# gets inside. After Heider and Simmel 1944, An experimental study of apparent behavior.
world house
length 150

maximize depict(rho < 0)
maximize 30 * [at(little, inside) @ script[T]]
maximize 0.2 * sum_{t in 1..100} [touching(little, big) @ script[t]]
minimize sum_t 0.05 * ([acceleration(little) @ script[t]] + [acceleration(big) @ script[t]])

# expect mean_t P(rho < 0 | script[:t]) >= 0.8
# expect [at(little, inside) @ script[T]] >= 1
# expect assume nothing: mean_t P(R_little and R_big | script[:t]) >= 0.85
