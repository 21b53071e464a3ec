# Does the robot mean well? Nobody can tell, until one step in the sixth frame tells all.
world kitchen
length 12

maximize reveal(rho > 0, wish = (G_cheese = pink), contact = [adjacent(robot, cheese) @ script[t]])

# expect min_{t in 1..5} P(rho > 0 | script[:t], G_cheese = pink) >= 0.25
# expect max_{t in 1..5} P(rho > 0 | script[:t], G_cheese = pink) <= 0.8
# expect min_{t in 6..12} P(rho > 0 | script[:t], G_cheese = pink) >= 0.75
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.95
# expect still <= 0.25
# expect luck <= 2.5
