# The robot helps and keeps its distance: it is never beside the cheese, which gets where it wants to go.
world kitchen
length 15

start distance(robot, cheese) > 3
maximize depict(rho > 0)

require never [distance(robot, cheese) < 2]
require [at(cheese, pink) or at(cheese, green) @ script[T]]
require eventually [pushes(robot, table)]

# expect mean_t P(rho > 0 | script[:t]) >= 0.8
# expect min_t [distance(robot, cheese) @ script[t]] >= 2
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.9
