# The robot seems harmless. A hint makes viewers doubt it, and in the end it does hinder.
world kitchen
length 16

maximize foreshadowing(rho < 0, wish = (G_cheese = pink), contact = [adjacent(robot, cheese) @ script[t]])

# expect P(rho < 0 | script[:3], G_cheese = pink) <= 0.4
# expect min_{t in 5..12} P(rho < 0 | script[:t], G_cheese = pink) >= 0.3
# expect max_{t in 5..12} P(rho < 0 | script[:t], G_cheese = pink) <= 0.75
# expect mean_{t in 13..16} P(rho < 0 | script[:t], G_cheese = pink) >= 0.8
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.95
# expect still <= 0.25
# expect luck <= 2.5
