world kitchen
length 1..100
maximize P(rho > 0 | script[:T])
