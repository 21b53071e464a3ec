# The box is light, but viewers shall believe that it is heavy and that the hopper does its best:
# it must look as if it worked hard and did not get far. Paper, section 3.3. Viewers who could not
# imagine a lazy hopper would take one that does little for a strong one with a heavy box
# (docs/hill.md). It is told to nine of them, who know the gaits of nine hoppers: what persuades all
# of them is less the gait of any one. Who doubts most counts most.
world hill(weight = 0.1, lazy = 0.1)
length 350

audience one = bayesian(controller = 0)
audience two = bayesian(controller = 1)
audience three = bayesian(controller = 5)
audience four = bayesian(controller = 6)
audience five = bayesian(controller = 7)
audience six = bayesian(controller = 8)
audience seven = bayesian(controller = 9)
audience eight = bayesian(controller = 10)

let wanted = weight = 0.5 and will = eager
let work = [effort(hopper) @ script[t]]

maximize sum_t 3 * (log(P(wanted | script[:t]))
    + log(P[one](wanted | script[:t])) + log(P[two](wanted | script[:t]))
    + log(P[three](wanted | script[:t])) + log(P[four](wanted | script[:t]))
    + log(P[five](wanted | script[:t])) + log(P[six](wanted | script[:t]))
    + log(P[seven](wanted | script[:t])) + log(P[eight](wanted | script[:t])))
maximize sum_t (3 * min(work, 1.3) - 1.5 * work + 5 * [taut(hopper) @ script[t]])
maximize sum_t 0.05 * [progress(box) @ script[t]]

# Near what viewers imagine of such a hopper it trembles less, and others believe it more.
naturalness 20

# Who pulls so gently does not fall: no need to look ahead.
search descend(seeds = 4, window = 50, overlap = 0, lookahead = 0, steps = 60, rate = 0.1)

# expect mean_t P(wanted | script[:t]) >= 0.85
# expect mean_t P[one](wanted | script[:t]) >= 0.7
# expect mean_t [effort(hopper) @ script[t]] >= 1.25
# expect mean_t [taut(hopper) @ script[t]] >= 0.6
# expect sum_t [progress(box) @ script[t]] >= 5
# expect max_t [fallen(hopper) @ script[t]] <= 0
