world kitchen
length 15
start moved(robot)
start [at(robot, pink) @ script[1]]
maximize sum_t at(robot, pink)
maximize sum_t [t @ script[t]]
