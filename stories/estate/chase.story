# Through the whole house: the mouse makes for its hole, and the cat is after it.
world estate
length 24
start at(mouse, (1, 12))

maximize depict(rho < 0 and G_mouse = hole) - 0.02 * sum_t [distance(cat, mouse) @ script[t]]

# expect mean_t P(rho < 0 and G_mouse = hole | script[:t]) >= 0.9
# expect mean_t [distance(cat, mouse) @ script[t]] <= 3
# expect assume nothing: mean_t P(R_mouse and R_cat | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
