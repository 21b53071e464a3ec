world hill
length 10
maximize P(weight = 0.5 | (script ++ [hopper: east])[:T+1])
maximize suspense(weight | script[:3])
maximize sum_t (if [effort(hopper) @ script[t]] then 1 else 0)
