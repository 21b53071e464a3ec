# The robot helps the cheese for a while, and then it does not: when it turns, and how long the film
# is, is for the search to say. Everybody knows what the cheese wants.
world kitchen
length 8..14

maximize beats(1.5 * depict(rho > 0 and G_cheese = pink), depict(rho < 0 and G_cheese = pink))

# What can be believed more easily would get nearly all frames: kindness counts more, and begins
# with a push.
require when [pushes(robot, cheese)] <= 4
require not [at(cheese, pink) @ script[T]]

# expect max_t P(rho > 0 and G_cheese = pink | script[:t]) >= 0.9
# expect P(rho < 0 and G_cheese = pink | script[:T]) >= 0.9
# expect sum_t [pushes(robot, cheese) @ script[t]] >= 2
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
