world hill
length 15
maximize depict(weight = 0.5)
pin script[1..3] = "take.json"
pin script[3] = "../take.json"
pin script[4] = "take"
