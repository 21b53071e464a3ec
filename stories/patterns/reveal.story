# A reveal: viewers cannot tell before the moment, and are certain from then on.
# Use it to answer a question at one stroke. A `mystery` keeps it open; a `twist` turns a belief.
# `event`: what is revealed. `moment`: the frame that reveals it. Not being able to tell is
# 4 p (1 - p), 1 at p = 1/2 and 0 where viewers are certain, so that being certain too early costs.
# `wish`: what everybody knows all along, such as what the other one wants, `G = x`.
# `steady`: what a nat of changed beliefs about anything else costs around the moment.
# `contact`: what shall be seen before and after it, such as `[adjacent(a, b) @ script[t]]`.
# After Barthes 1970, S/Z: the `disclosure` of the hermeneutic code.
pattern reveal(event, moment = T/2, wish = 1 = 1, steady = 0.5, contact = 0) =
    sum_t (if t < moment
           then 4 * P(event | script[:t], wish) * (1 - P(event | script[:t], wish))
           else P(event | script[:t], wish))
    + max_t (if t < moment then contact else 0) + max_t (if t >= moment then contact else 0)
    - steady * sum_t (if abs(t - moment) <= 1
                      then KL(others(event); script[:t-1] || script[:t]) else 0)
