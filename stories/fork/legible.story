# The robot moves so that viewers know early where it is going: legible motion, Dragan 2015.
world fork
length 9
start at(robot, (4, 4))

maximize sum_t P(G_robot = left | script[:t])
