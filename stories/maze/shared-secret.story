# Who knows that the mouse wants its hole sees a cat that helps it; everybody else, a bully.
world maze
length 14

audience friend = bayesian(given = G_mouse = hole)

maximize shared_secret(friend, viewers, rho > 0)

# expect mean_t P[friend](rho > 0 | script[:t]) >= 0.95
# expect mean_t P(rho > 0 | script[:t]) <= 0.05
# expect assume nothing: mean_t P(R_mouse and R_cat | script[:t]) >= 0.95
# expect still <= 0.25
# expect luck <= 2.5
