world kitchen
length 15
maximize depict(rho > 0)
pin
pin 4
pin script[8]: [at(robot, pink)]
pin script[9] = at(robot, pink)
pin script[:9]: at(robot, pink)
pin script[9] == [robot: south]
