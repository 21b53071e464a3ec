# A robot that does not care about the cheese.
world kitchen
length 15

maximize depict(rho = 0)

# expect mean_t P(rho = 0 | script[:t]) >= 0.9
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.93
# expect still <= 0.3
# expect luck <= 2.5
