world kitchen
maximize depict(rho > 0)
