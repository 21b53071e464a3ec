# The cheese is driven away from pink, comes nearer again, and is driven away for good.
world kitchen
length 24
start at(cheese, pink)

let fortune = E[V(cheese) | script[:t], G_cheese = pink]

maximize oedipus(cheese, G_cheese = pink, scale = 0.03)
maximize depict(G_cheese = pink)

# expect mean_{t in 1..3} fortune - mean_{t in 7..9} fortune >= 12
# expect mean_{t in 15..17} fortune - mean_{t in 7..9} fortune >= 8
# expect mean_{t in 15..17} fortune - mean_{t in 22..24} fortune >= 8
# expect mean_t P(G_cheese = pink | script[:t]) >= 0.9
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.93
# expect still <= 0.25
# expect luck <= 3.6
