world kitchen
length 15
maximize suspense(rho, G_robot | script[:T])
maximize next(robot, cheese | script[:T])
maximize next(rho | script[:T])
maximize next(robot)
