# The robot hurries to pink, and viewers think that pink is what it is after. It is not.
world kitchen
length 18

maximize red_herring(G_robot = pink)

# expect mean_{t in 5..12} P(G_robot = pink | script[:t]) >= 0.9
# expect P(G_robot = pink | script[:T]) <= 0.1
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.94
# expect still <= 0.3
# expect luck <= 2.5
