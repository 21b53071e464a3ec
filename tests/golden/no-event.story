world kitchen
length 15
allow rain(table), deus
let shown = script ++ [deus: robot at pink]
let later = script ++ [rain: table at pink]
maximize depict(rho > 0)
