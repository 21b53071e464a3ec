# The cheese is far from pink and alone, or worse; in the end it is there.
world kitchen
length 24

let fortune = E[V(cheese) | script[:t], G_cheese = pink]

maximize rags_to_riches(cheese, G_cheese = pink, scale = 0.08)
liveliness 0.8
maximize depict(G_cheese = pink)

# expect mean_{t in 22..24} fortune - mean_{t in 1..3} fortune >= 30
# expect mean_t P(G_cheese = pink | script[:t]) >= 0.9
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.93
# expect still <= 0.25
# expect luck <= 3.6
