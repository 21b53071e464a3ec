# The robot clears the way before the cheese comes along, and never stands beside it.
world kitchen
length 15

start distance(cheese, pink) > 5 and distance(cheese, green) > 5
maximize depict(rho > 0)

require [pushes(robot, table)] before [at(cheese, pink) or at(cheese, green)]
require when [pushes(robot, table)] < 6
require never [distance(robot, cheese) < 2]

# expect mean_t P(rho > 0 | script[:t]) >= 0.8
# expect min_t [distance(robot, cheese) @ script[t]] >= 2
# expect when [pushes(robot, table)] <= 5
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
