world kitchen
length 15
maximize depict(rho > 0)
pin script[4] = [robot: south, mouse: west]
pin script[16]: at(robot, pink)
pin script[0]: at(robot, pink)
pin script[5] = [robot: south]
pin script[5] = [robot: north]
pin script[6]: at(robot, pink) and at(cheese, pink)
pin script[7]: at(robot, pink)
pin script[7..9]: at(robot, green)
pin script[9..8]: moved(robot)
pin script[3]: rho > 0
pin script[3]: distance(robot, cheese)
pin script[3] = [deus: table at (1, 3)]
pin script[t]: moved(robot)
pin script[3] = [robot: south!]
