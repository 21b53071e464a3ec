world kitchen
length 15
maximize sum_t entropy(robot | script[:t])
maximize sum_t KL(G_chese; script[:t-1] || script[:t])
maximize sum_t suspense(rho > 0 | script[:t])
