# The hopper's fortune rises, and sinks when it stands highest: Icarus.
# After Reagan et al. 2016.
world hill(weight = 0.5)
length 800

maximize icarus(hopper)
minimize sum_t 1000 * [fallen(hopper) @ script[t]]

let wings = -cos(2*pi * t/T)
let fortune = E[V(hopper) | script[:t]]

# expect (mean_t (wings * fortune) - (mean_t wings) * (mean_t fortune)) / sqrt((mean_t wings^2 - (mean_t wings)^2) * (mean_t fortune^2 - (mean_t fortune)^2)) >= 0.6
# expect max_t [fallen(hopper) @ script[t]] <= 0
