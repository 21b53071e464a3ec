world kitchen
length 15
maximize sum_t P(roh > 0 | script[:t])
maximize sum_t P(G_chese = pink | script[:t])
maximize depict(pink)
maximize robot
maximize moved
maximize sin
maximize quux
start table
