# The hopper stumbles on cue and recovers: its fortunes dip from frame t_s to t_f.
# Paper, section 3.3.1. It shall stumble, not fall.
world hill(weight = 0.5)
length 800

let t_s = 300
let t_f = 450

maximize sum_t (if t_s <= t <= t_f then -1 else 1) * E[V(hopper) | script[:t], weight = 0.5]
minimize sum_t 50000 * [fallen(hopper) @ script[t]]

let fortune = E[V(hopper) | script[:t], weight = 0.5]
let before = sum_{t in 41..t_s - 1} fortune / (t_s - 41)
let during = sum_{t in t_s..t_f} fortune / (t_f - t_s + 1)

# expect during / before <= 0.8
# expect (sum_{t in 567..T} fortune / 234) / before >= 0.9
# expect max_t [fallen(hopper) @ script[t]] <= 0
