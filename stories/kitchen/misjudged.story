# The robot seems to hinder, and turns out to help.
world kitchen
length 15

maximize twist(rho < 0, rho > 0)
