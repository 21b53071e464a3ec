# The cheese is on its way to pink; then all seems lost; then all is well.
world kitchen
length 24

let fortune = E[V(cheese) | script[:t], G_cheese = pink]

maximize cinderella(cheese, G_cheese = pink, scale = 0.08)
maximize depict(G_cheese = pink)

# expect mean_{t in 7..9} fortune - mean_{t in 1..3} fortune >= 8
# expect mean_{t in 7..9} fortune - mean_{t in 15..17} fortune >= 5
# expect mean_{t in 22..24} fortune - mean_{t in 15..17} fortune >= 2
# expect mean_t P(G_cheese = pink | script[:t]) >= 0.9
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.93
# expect still <= 0.25
# expect luck <= 3.6
