world kitchen
length 15
let x = foo + 1
let good = G_cheese = blue
pattern p(x) = sum_t P(x | script[:t]) * rhoo
maximize depict(rho > 0)
