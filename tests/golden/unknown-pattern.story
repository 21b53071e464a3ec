world kitchen
length 15
maximize depcit(rho > 0)
maximize sum(3)
maximize p(rho > 0)
