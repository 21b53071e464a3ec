world smooth
length 15
maximize sum_t suspense(rho | script[:t])
