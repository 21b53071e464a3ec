# The robot drops everything to help the cheese. What does it want for itself?
world kitchen
length 14

maximize mystery(G_robot)

# expect min_t entropy(G_robot | script[:t]) / log(3) >= 0.9
# expect entropy(script[:T]) - entropy(G_robot | script[:T]) <= 0.2
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.95
# expect still <= 0.25
# expect luck <= 2.5
