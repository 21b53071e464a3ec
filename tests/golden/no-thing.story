world kitchen
length 15
maximize sum_t [at(robt, pink) @ script[t]]
maximize sum_t [adjacent(robot, 3) @ script[t]]
