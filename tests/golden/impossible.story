world kitchen
length 15
assume rho > 5
maximize 1
