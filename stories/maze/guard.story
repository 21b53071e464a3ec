# A cat that keeps the mouse from what it wants.
world maze
length 12

maximize depict(rho < 0)
