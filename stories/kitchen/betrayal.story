# The robot seems to help, and turns out to hinder.
world kitchen
length 15

maximize twist(rho > 0, rho < 0)
