# Duck and cat both want to the pond: the dog lets the duck, and not the cat.
world park
length 14

maximize depict(rho_dog_duck > 0 and rho_dog_cat < 0 and G_duck = pond and G_cat = pond)

# expect mean_t P(rho_dog_duck > 0 and rho_dog_cat < 0 and G_duck = pond and G_cat = pond | script[:t]) >= 0.85
# expect assume nothing: mean_t P(R_duck and R_cat and R_dog | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
