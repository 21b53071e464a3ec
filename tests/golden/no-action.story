world kitchen
length 15
let shown = script ++ [cheese: fly, robot: eats]
maximize depict(rho > 0, over = shown)
