world kichen
length 15
maximize depict(rho > 0)
