world kitchen
length 15

maximize sum_t sin() * max(t) * sqrt(x = 2)
maximize sum_t [at(robot) @ script[t]]
maximize sum_t [moved(who = robot) @ script[t]]
maximize sum_t points((0, 0)) * points((1, 0), (0, 1)) * points(1, 2)
