# Those who know that both want to the hay see a dog who helps the duck and keeps the cat away; to everybody
# else he bullies the duck.
world park
length 14

audience insider = bayesian(given = G_duck = hay and G_cat = hay)

maximize shared_secret(insider, viewers, rho_dog_duck > 0) + sum_t P[insider](rho_dog_cat < 0 | script[:t])

# expect mean_t P[insider](rho_dog_duck > 0 | script[:t]) >= 0.85
# expect mean_t P(rho_dog_duck > 0 | script[:t]) <= 0.1
# expect assume nothing: mean_t P(R_duck and R_cat and R_dog | script[:t]) >= 0.85
# expect still <= 0.25
# expect luck <= 2.5
