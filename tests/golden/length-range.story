world kitchen
length 12..20
maximize P(rho > 0 | script[:T/2])
maximize P(rho > 0 | script[:T])
