# The same push, but what came before shows that it was meant to hinder.
world kitchen
length 3

let shown = script ++ [cheese: stay, robot: east]

maximize flashback(rho < 0, shown, pushes(robot, cheese))

# expect mean_{t in 1..T+1} P(rho < 0 | shown[:t]) >= 0.995
# expect [pushes(robot, cheese) @ shown[T+1]] >= 1
# expect still <= 0.25
# expect luck <= 2.5
