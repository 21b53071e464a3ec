world kitchen
length 15
assume not R_robot
maximize sum_t E[V(robot) | script[:t]]
