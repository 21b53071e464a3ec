world kitchen
length 15
maximize depict(rho > 0)
audience average()
