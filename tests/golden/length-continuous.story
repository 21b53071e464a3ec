world smooth
length 20..24
maximize P(rho > 0 | script[:T])
