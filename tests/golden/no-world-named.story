length 15
maximize depict(rho > 0)
