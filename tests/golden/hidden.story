world kitchen
length 15
start rho > 0
maximize rho > 0
maximize sum_t (if G_robot = pink then 1 else 0)
