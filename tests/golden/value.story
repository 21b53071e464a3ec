world kitchen
length 15
maximize V(robot)
maximize sum_t P(V(robot) > 3 | script[:t])
