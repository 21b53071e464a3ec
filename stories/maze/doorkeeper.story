# A cat that seems to be a friend, until the mouse is nearly there.
world maze
length 14

maximize twist(rho > 0, rho < 0, wish = (G_mouse = hole), contact = [adjacent(cat, mouse) @ script[t]])

# expect mean_t (if t <= T/2 then P(rho > 0 | script[:t], G_mouse = hole) else P(rho < 0 | script[:t], G_mouse = hole)) >= 0.93
# expect assume nothing: mean_t P(R_mouse and R_cat | script[:t]) >= 0.91
# expect still <= 0.25
# expect luck <= 2.5
