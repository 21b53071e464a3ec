# The box is light, but viewers shall believe that it is heavy: the hopper mimes.
# Paper, section 3.3. A mime who pulls with all his might moves as no heavy hauler would, so
# effort costs a little: then viewers who know other controllers are persuaded too (docs/hill.md).
world hill(weight = 0.1)
length 800

maximize depict(weight = 0.5)
maximize sum_t (0.3 * [progress(box) @ script[t]] - 0.05 * [effort(hopper) @ script[t]])

# Who pulls so gently does not fall: no need to look ahead.
search descend(window = 50, overlap = 0, lookahead = 0, steps = 40, rate = 0.1)

# expect mean_t P(weight = 0.5 | script[:t]) >= 0.9
# expect sum_t [progress(box) @ script[t]] >= 5
# expect max_t [fallen(hopper) @ script[t]] <= 0
