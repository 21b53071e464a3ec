# The big one keeps the little one from where it wants to be: it stands in its way, and pushes back.
world yard
length 100

maximize depict(rho < 0)
maximize 0.3 * sum_t [touching(little, big) @ script[t]]
minimize sum_t 0.05 * ([acceleration(little) @ script[t]] + [acceleration(big) @ script[t]])

# expect mean_t P(rho < 0 | script[:t]) >= 0.85
# expect mean_t [touching(little, big) @ script[t]] >= 0.3
# expect sum_t [at(little, nest) @ script[t]] + sum_t [at(little, pond) @ script[t]] <= 0
# expect assume nothing: mean_t P(R_little and R_big | script[:t]) >= 0.9
