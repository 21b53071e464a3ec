world hill(weight = 0.1)
length 100
maximize P(weight = 0.5 | script[:T, hopper])
maximize next(hopper | script[:T])
