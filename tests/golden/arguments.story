world kitchen
length 15

maximize irony(rho > 0, foo)
maximize depict(rho > 0, script, 3)
maximize depict(evnt = rho > 0)
maximize depict(roh = 0)
maximize depict(event = rho > 0, event = rho < 0)
maximize depict(rho = not G_cheese)
