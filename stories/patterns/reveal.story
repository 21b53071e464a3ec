# A reveal: viewers cannot tell before the moment, and are certain from then on.
# Use it to answer a question at one stroke. A `mystery` keeps it open; a `twist` turns a belief.
# `event`: what is revealed. `moment`: the frame that reveals it. Not being able to tell is
# 4 p (1 - p), 1 at p = 1/2 and 0 where viewers are certain, so that being certain too early costs.
# After Barthes 1970, S/Z: the `disclosure` of the hermeneutic code.
pattern reveal(event, moment = T/2) =
    sum_t (if t < moment
           then 4 * P(event | script[:t]) * (1 - P(event | script[:t]))
           else P(event | script[:t]))
