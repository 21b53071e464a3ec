# The hopper's fortune rises, falls and rises again, one and a half turns of a sine:
# the shape of a story, told by the same pattern as in the kitchen.
# After Reagan et al. 2016; paper, sections 3.1.5 and 3.3.1.
world hill(weight = 0.5)
length 800

maximize arc(hopper)
minimize sum_t 1000 * [fallen(hopper) @ script[t]]

let tide = sin(t/T * 3*pi)
let fortune = E[V(hopper) | script[:t]]

# expect (mean_t (tide * fortune) - (mean_t tide) * (mean_t fortune)) / sqrt((mean_t tide^2 - (mean_t tide)^2) * (mean_t fortune^2 - (mean_t fortune)^2)) >= 0.7
# expect max_t [fallen(hopper) @ script[t]] <= 0
