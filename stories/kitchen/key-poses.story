# Key poses, as an animator sets them: the robot stands beside the cheese in frame 4, pushes it in
# frame 8, and in the end both are on their tiles. What leads from one to the next is found.
world kitchen
length 14

maximize depict(rho > 0 and G_cheese = pink)

pin script[4]: adjacent(robot, cheese) and not at(cheese, pink)
pin script[8]: pushes(robot, cheese)
pin script[T]: at(cheese, pink) and at(robot, green)

# expect mean_t P(rho > 0 | script[:t]) >= 0.9
# expect [adjacent(robot, cheese) @ script[4]] >= 1
# expect [pushes(robot, cheese) @ script[8]] >= 1
# expect [at(cheese, pink) and at(robot, green) @ script[T]] >= 1
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
