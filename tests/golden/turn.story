world kitchen
length 15
let a = script ++ [cheese: stay!, robot: east]
let b = script ++ [cheese: stay, robot: east!]
let c = script ++ [robot: east]
let d = script ++ [cheese: stay, cheese: stay, robot: east]
let e = script ++ [deus: table at pink, robot: east]
maximize 1
