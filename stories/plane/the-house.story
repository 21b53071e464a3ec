# The little one wants to get into the house; the big one runs after it, catches it at the door or
# inside, and drives it into a corner. After Heider and Simmel 1944, An experimental study of
# apparent behavior.
world house
length 120

maximize depict(rho < 0 and G_little = inside)
minimize sum_t 0.2 * [distance(little, big) @ script[t]]
maximize sum_{t in 1..T/3} 3 * [progress(little, inside) @ script[t]]
minimize sum_{t in T/2..T} 3 * [progress(little, inside) @ script[t]]
minimize sum_t 0.1 * ([acceleration(little) @ script[t]] + [acceleration(big) @ script[t]])

# expect mean_t P(rho < 0 and G_little = inside | script[:t]) >= 0.85
# expect sum_{t in 1..T/3} [progress(little, inside) @ script[t]] >= 1.5
# expect sum_{t in T/2..T} [progress(little, inside) @ script[t]] <= -1
# expect mean_{t in T/2..T} [touching(little, big) @ script[t]] >= 0.4
# expect assume nothing: mean_t P(R_little and R_big | script[:t]) >= 0.9
