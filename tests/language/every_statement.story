import depict
import "stories/patterns"
world kitchen(beta = 1.5)
length 11..12
start absent(table)
allow deus(table)
let shown = script ++ [cheese: stay, robot: east]

# Not its documentation.

# Two lines
# of documentation.
pattern rise(event, over = script, slope = 1 / T) =
    sum_t slope * t * P(event | over[:t])
pattern nothing() = 0
maximize rise(rho > 0, over = shown)
minimize nothing()
rationality 0.5
plausibility 0
naturalness 0.2
luck 1
liveliness 0.05
assume R_robot and R_cheese
audience average(bayesian(beta = 1), bayesian(prior = if rho > 0 then 2 else 1))
search beam(starts = 100, width = 2)
require never [moved(robot)] and when [moved(cheese)] < 3
require [moved(cheese)] before [adjacent(robot, cheese)]
require eventually [moved(cheese)]
pin script[4] = [robot: south]
pin script[8..T]: at(robot, pink) and moved(cheese)
maximize beats(depict(rho > 0), sum_t P(rho < 0 | script[:t]))
