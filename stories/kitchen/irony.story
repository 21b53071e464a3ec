# The robot means well, but mistakes the cheese's goal.
world kitchen
length 25

maximize irony(G_cheese = green, G_cheese = pink, rho > 0, rho < 0)

# expect mean_t P(G_cheese = green | script[:t]) >= 0.88
# expect mean_t P(rho < 0 | script[:t], G_cheese = green) >= 0.9
# expect mean_t P(rho > 0 | script[:t], G_cheese = pink) >= 0.88
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.93
# expect still <= 0.3
# expect luck <= 3
