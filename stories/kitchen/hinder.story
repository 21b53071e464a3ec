# A robot that hinders the cheese.
world kitchen
length 15

maximize depict(rho < 0)
