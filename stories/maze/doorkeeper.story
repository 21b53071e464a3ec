# A cat that seems to be a friend, until the mouse is nearly there.
world maze
length 14

maximize twist(rho > 0, rho < 0)
