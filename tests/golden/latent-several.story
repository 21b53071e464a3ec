world kitchen
length 15
maximize P(G_cheese, rho > 0 | script[:T])
maximize P(G_cheese, roh | script[:T])
maximize P(rho, rho | script[:T])
