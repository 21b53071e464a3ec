# A go-between: duck and cat both want to the pond, and the dog brings them there both.
world park
length 12

maximize depict(rho_dog_duck > 0 and rho_dog_cat > 0 and G_duck = pond and G_cat = pond)
    + max_t [pushes(dog, duck) @ script[t]] + max_t [pushes(dog, cat) @ script[t]]

liveliness 0.5

# expect mean_t P(rho_dog_duck > 0 and rho_dog_cat > 0 and G_duck = pond and G_cat = pond | script[:t]) >= 0.85
# expect sum_t [pushes(dog, duck) @ script[t]] >= 1
# expect sum_t [pushes(dog, cat) @ script[t]] >= 1
# expect assume nothing: mean_t P(R_duck and R_cat and R_dog | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
