# The big one pushes the little one to its nest. Who knows that it wants to be there sees how it is
# helped; everybody else believes that it is kept from the pond.
world pasture
length 100

audience friend = bayesian(given = G_little = nest)

maximize shared_secret(friend, viewers, rho > 0)
maximize sum_t 3 * [progress(little, nest) @ script[t]]
minimize sum_t 0.3 * [distance(little, big) @ script[t]]
minimize sum_t 0.05 * ([acceleration(little) @ script[t]] + [acceleration(big) @ script[t]])

# expect mean_{t in T/2..T} P[friend](rho > 0 | script[:t]) >= 0.85
# expect mean_{t in T/2..T} P(rho < 0 | script[:t]) >= 0.6
# expect mean_t P(rho > 0 | script[:t]) <= 0.2
# expect sum_t [progress(little, nest) @ script[t]] >= 5
# expect mean_t [touching(little, big) @ script[t]] >= 0.3
# expect assume nothing: mean_t P(R_little and R_big | script[:t]) >= 0.9
