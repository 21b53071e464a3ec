# Killed with kindness: the duck wants to the hay. The dog means well, takes it to want to the pond, and brings
# it there.
world farm
length 14

maximize depict(rho > 0 and G_duck = hay and B_dog_duck = pond)

# expect mean_t P(rho > 0 and G_duck = hay and B_dog_duck = pond | script[:t]) >= 0.9
# expect sum_t [pushes(dog, duck) @ script[t]] >= 1
# expect assume nothing: mean_t P(R_duck and R_dog | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
