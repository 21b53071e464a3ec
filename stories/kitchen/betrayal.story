# The robot seems to help, and turns out to hinder.
world kitchen
length 15

maximize twist(rho > 0, rho < 0)

# expect mean_t (if t <= T/2 then P(rho > 0 | script[:t]) else P(rho < 0 | script[:t])) >= 0.93
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.97
