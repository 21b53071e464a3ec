world kitchen
length 15
start 3
maximize script
maximize "text"
maximize sum_t rho
maximize depict(3)
maximize sum_t P(rho > 0 | script)
maximize sum_t P(rho > 0 | script[t])
maximize sum_t surprise(script[:t])
maximize sum_t [at(robot, pink) @ script[:t]]
maximize last(script[:3])
maximize t > 3
maximize sum_t (if t > 3 then 1 else t > 2)
