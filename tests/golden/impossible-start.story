world kitchen
length 15
start at(robot, (0, 0)) and at(cheese, (0, 0))
maximize 1
