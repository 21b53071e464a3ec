world kitchen
length 15

maximize 1/0
maximize log(-1)
maximize sqrt(0 - 2)
maximize 10^400
maximize sum_t 1/(t - 3)
maximize sum_t P(rho > 0 | script[:t]) * log(t - 1)
maximize sum_t (if 1/(t - 2) > 0 then P(rho > 0 | script[:t]) else 0)
