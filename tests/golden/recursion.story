world kitchen
length 15
pattern p(x) = q(x)
pattern q(x) = p(x)
let a = a + 1
maximize p(rho > 0)
