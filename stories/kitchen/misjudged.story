# The robot seems to hinder, and turns out to help.
world kitchen
length 15

maximize twist(rho < 0, rho > 0, wish = (G_cheese = pink), contact = [adjacent(robot, cheese) @ script[t]])

# expect mean_t (if t <= T/2 then P(rho < 0 | script[:t], G_cheese = pink) else P(rho > 0 | script[:t], G_cheese = pink)) >= 0.88
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.93
# expect still <= 0.25
# expect luck <= 2.5
