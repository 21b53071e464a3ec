# The robot means well, but mistakes the cheese's goal.
world kitchen
length 25

maximize irony(G_cheese = green, G_cheese = pink, rho > 0, rho < 0)
