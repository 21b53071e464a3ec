world kitchen
length 15
let turn = T/2
maximize twist(rho > 0, rho < 0, turn(3))
