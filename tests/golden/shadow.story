world kitchen
length 15
let rho = 3
pattern show(G_cheese) = sum_t P(G_cheese | script[:t])
maximize show(rho > 0)
