# The robot moves so that viewers know early where it is going.
world fork
length 9
start at(robot, (4, 4))

maximize legible(G_robot = left)

# expect mean_t P(G_robot = left | script[:t]) >= 0.95
# expect P(G_robot = left | script[:2]) >= 0.95
# expect assume nothing: mean_t P(R_robot | script[:t]) >= 0.85
# expect still <= 0.25
