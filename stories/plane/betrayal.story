# The big one helps the little one on its way, it seems; half way there it turns against it.
world pasture
length 140

maximize twist(rho > 0, rho < 0)
minimize sum_t 0.05 * ([acceleration(little) @ script[t]] + [acceleration(big) @ script[t]])

# expect mean_{t in 1..T/2} P(rho > 0 | script[:t]) >= 0.8
# expect mean_{t in T/2 + 6..T} P(rho < 0 | script[:t]) >= 0.9
# expect assume nothing: mean_t P(R_little and R_big | script[:t]) >= 0.9
