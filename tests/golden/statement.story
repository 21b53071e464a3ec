World kitchen
lenght 15
sum_t P(rho > 0 | script[:t])
turn = 3
the robot helps
