# The robot walks to the right door, and in the last moment to the left one: a feint.
world fork
length 14
start at(robot, (4, 4))

# One step nearer to a door is worth 2 here, so a unit of fortune must count more than usual; with
# more than 0.3 it hurries to the left door and the feint is lost.
maximize deceptive(robot, G_robot = left, G_robot = right, scale = 0.3)

# expect mean_{t in 1..7} P(G_robot = right | script[:t]) >= 0.9
# expect [at(robot, left) @ script[T]] >= 1
# expect assume nothing: mean_t P(R_robot | script[:t]) >= 0.8
# expect still <= 0.25
