# The robot helps the cheese for a while, and then it does not: when it turns, and how long the film
# is, is for the search to say. Everybody knows what the cheese wants.
world kitchen
length 8..14

maximize beats(depict(rho > 0 and G_cheese = pink), depict(rho < 0 and G_cheese = pink))

require eventually [pushes(robot, cheese)]

# expect max_t P(rho > 0 and G_cheese = pink | script[:t]) >= 0.8
# expect P(rho < 0 and G_cheese = pink | script[:T]) >= 0.9
# expect sum_t [pushes(robot, cheese) @ script[t]] >= 1
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.8
