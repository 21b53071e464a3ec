# Duck and cat both want to the pond. First the dog is the duck's friend and the cat's foe, then the other
# way round.
world park
length 16

maximize twist(rho_dog_duck > 0 and rho_dog_cat < 0, rho_dog_duck < 0 and rho_dog_cat > 0, wish = (G_duck = pond and G_cat = pond))

# expect mean_t (if t <= T/2 then P(rho_dog_duck > 0 and rho_dog_cat < 0 | script[:t], G_duck = pond and G_cat = pond) else P(rho_dog_duck < 0 and rho_dog_cat > 0 | script[:t], G_duck = pond and G_cat = pond)) >= 0.75
# expect assume nothing: mean_t P(R_duck and R_cat and R_dog | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
