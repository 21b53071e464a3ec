# A cat that keeps the mouse from what it wants.
world maze
length 12

maximize depict(rho < 0)

# expect mean_t P(rho < 0 | script[:t]) >= 0.95
# expect assume nothing: mean_t P(R_mouse and R_cat | script[:t]) >= 0.95
# expect still <= 0.25
# expect luck <= 2.5
