world kitchen
length 15
maximize .5 * depict(rho > 0)
maximize 2 depict(rho > 0)
maximize 2 * if T > 3 then 1 else 2
maximize sum_{i in 1..5} 1
maximize sum_{t in 1...5} 1
maximize sum_{t in 1-5} 1
maximize sum P(rho > 0 | script[:t])
maximize sum_t (if t > 3 then 1)
maximize if T > 3
maximize 2 *
