world kitchen
length 15
maximize depict(rho > 0)
pin script[3] = "take.json"
pin script[4..20] = "take.json"
