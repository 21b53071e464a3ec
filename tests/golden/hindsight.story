world kitchen
length 15
maximize P(rho > 0 @ 8 | script[:T])
maximize sum_t P(rho > 0 @ script[:t] | script[:T])
maximize P(rho > 0 @ script[16] | script[:T])
maximize suspense(rho @ script[1] | script[:2])
maximize P(rho > 0 @ script[1])
let one = script ++ [cheese: stay, robot: east]
let other = script ++ [cheese: stay, robot: west]
maximize P(rho > 0 @ one[T+1] | other[:T+1])
maximize P(G_cheese @ script[1] | script[:T])
