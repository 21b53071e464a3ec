# The dog fetches the key and opens the door, for the child wants to the garden.
world cellar
length 15
start at(child, (3, 4)) and at(dog, (2, 0))

maximize depict(rho > 0 and G_child = garden)
require [at(child, garden) @ script[T]]

# expect mean_t P(rho > 0 and G_child = garden | script[:t]) >= 0.75
# expect sum_t [opens(dog, door) @ script[t]] >= 1
# expect [at(child, garden) @ script[T]] >= 1
# expect assume nothing: mean_t P(R_child and R_dog | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
