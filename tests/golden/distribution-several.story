world kitchen
length 15
maximize P(G_cheese, rho | script[:T])
maximize sum_t next(robot | script[:t])
