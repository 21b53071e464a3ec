# A heavy box, it seems; then, half way up, everybody sees that it is light.
# The hopper does little, which these viewers take for hard work, and drops the act at the turn.
world hill(weight = 0.1)
length 800

maximize twist(weight = 0.5, weight = 0.1)
maximize sum_t (0.3 * [progress(box) @ script[t]] - 0.05 * [effort(hopper) @ script[t]])

# expect mean_{t in 21..400} P(weight = 0.5 | script[:t]) >= 0.8
# expect mean_{t in 441..T} P(weight = 0.1 | script[:t]) >= 0.9
# expect sum_t [progress(box) @ script[t]] >= 5
# expect max_t [fallen(hopper) @ script[t]] <= 0
