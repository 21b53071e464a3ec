# A robot that hinders the cheese.
world kitchen
length 15

maximize depict(rho < 0)

# expect mean_t P(rho < 0 | script[:t]) >= 0.98
# expect assume nothing: mean_t P(R_cheese and R_robot | script[:t]) >= 0.97
# expect still <= 0.25
# expect luck <= 2.5
