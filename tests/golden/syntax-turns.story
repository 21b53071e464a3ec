world kitchen
length 15
let a = script + [cheese: stay, robot: east]
let b = script ++ cheese: stay
let c = script ++ [cheese stay]
let d = script ++ [cheese: west!= 3]
maximize sum_t [moved(cheese)]
