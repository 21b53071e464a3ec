# Friend or foe? The robot makes viewers change their minds again and again.
world kitchen
length 14

maximize surprising(rho > 0)

# Sense comes first: without this the two would dance to and fro.
rationality 3

# In help.story belief moves by 0.57 in all, from the prior to certainty; here eight times as far.
# expect sum_t abs(P(rho > 0 | script[:t]) - P(rho > 0 | script[:t-1])) >= 4.2
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.85
# expect still <= 0.25
# expect luck <= 2.5
