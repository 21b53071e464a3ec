# Who knows that the little one wants its nest sees how the big one helps it there; everybody else
# believes that it is driven away from the pond.
world pasture
length 100

audience friend = bayesian(given = G_little = nest)

maximize shared_secret(friend, viewers, rho > 0)
minimize sum_t 0.3 * [distance(little, big) @ script[t]]
minimize sum_t 0.05 * ([acceleration(little) @ script[t]] + [acceleration(big) @ script[t]])

search descend(optimiser = adam, rate = 0.004, steps = 150)

# expect mean_t P[friend](rho > 0 | script[:t]) >= 0.8
# expect mean_t P(rho > 0 | script[:t]) <= 0.4
# expect assume nothing: mean_t P(R_little and R_big | script[:t]) >= 0.9
