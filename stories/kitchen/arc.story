# The robot's fortune rises, falls and rises again; a table may fall from the sky.
world kitchen
length 25
start absent(table)
allow deus(table)

let tide = sin(t/T * 3*pi)
let fortune = E[V(robot) | script[:t]]

maximize arc(robot, scale = 0.1)

# expect (mean_t (tide * fortune) - (mean_t tide) * (mean_t fortune)) / sqrt((mean_t tide^2 - (mean_t tide)^2) * (mean_t fortune^2 - (mean_t fortune)^2)) >= 0.6
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.97
# expect still <= 0.34
# expect luck <= 3.6
