# The mouse must pass, and the cat is there. Each step may show whether it means harm.
world maze
length 14

maximize suspenseful(rho)

# To look ahead takes time: fewer first pictures.
search beam(starts = 100, polish = 0)

# In doorkeeper.story it is 0.05 a frame, in guard.story 0.001.
# expect mean_t sqrt(suspense(rho | script[:t])) >= 0.33
# expect assume nothing: mean_t P(R_mouse and R_cat | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
