world kitchen
length 5
maximize depict(rho > 0)
require
require [at(robot, pink)]
require never [moved(robot) @ script[3]]
require never moved(robot)
require [moved(robot)] before moved(cheese)
require [moved(robot)] before [moved(cheese) @ script[T]]
requires never [moved(robot)]
