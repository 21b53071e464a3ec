world kitchen
length 15
maximize sum_t KL(script[:t])
