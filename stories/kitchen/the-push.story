# The robot seems to help until it pushes the cheese for the first time; then nobody believes it any more.
world kitchen
length 15

maximize twist(rho > 0, rho < 0, turn = when [pushes(robot, cheese)])

require 4 < when [pushes(robot, cheese)] <= 9
require [adjacent(robot, cheese)] before [pushes(robot, cheese)]
require not [at(cheese, pink) or at(cheese, green) @ script[T]]

# expect mean_t (if t <= when [pushes(robot, cheese)] then P(rho > 0 | script[:t]) else P(rho < 0 | script[:t])) >= 0.9
# expect when [pushes(robot, cheese)] <= 9
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
