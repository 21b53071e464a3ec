world kitchen
length 15
maximize sum_t E[V(robbot) | script[:t]]
maximize arc(table)
maximize arc(3)
