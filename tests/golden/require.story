world kitchen
length 5
maximize depict(rho > 0)
require P(rho > 0 | script[:T])
require rho > 0
require 1 > 2
require [moved(robot) @ script[9]]
require eventually [moved(robto)] or never [moved(robot) or moved(cheese)]
require [speed(robot)] before [absent(robot)]
