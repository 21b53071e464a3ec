world kitchen
length 15
maximize sum_t [at(robot, blue) @ script[t]]
maximize sum_t [at(robot, (50, 1)) @ script[t]]
maximize sum_t [at(robot, (3, 0)) @ script[t]]
maximize sum_t [at(robot, (0.5, 0)) @ script[t]]
maximize sum_t [at(robot, 3) @ script[t]]
