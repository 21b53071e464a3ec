# A robot that does not care about the cheese.
world kitchen
length 15

maximize depict(rho = 0)
