# Foreshadowing: nobody expects it; an early hint is half believed; then it comes true.
# Use it to prepare a turn, so that it is felt to be earned when it comes.
# `event`: what comes true. `hint`: the frame of the hint, before which viewers shall not believe
# in the event. `comes`: the last frame before it comes true. Half belief is 4 p (1 - p), which is
# 1 at p = 1/2 and 0 where viewers are certain.
# `wish`: what everybody knows all along, such as what the other one wants, `G = x`.
# `steady`: what a nat of changed beliefs about anything else costs around `comes`.
# `contact`: what shall be seen before and after it, such as `[adjacent(a, b) @ script[t]]`.
# After Bae and Young 2008, A use of flashback and foreshadowing for surprise arousal.
pattern foreshadowing(event, hint = T/4, comes = 3/4 * T, wish = 1 = 1, steady = 0.5, contact = 0) =
    sum_t (if t < hint then 1 - P(event | script[:t], wish)
           else if t <= comes
           then 4 * P(event | script[:t], wish) * (1 - P(event | script[:t], wish))
           else P(event | script[:t], wish))
    + max_t (if t <= comes then contact else 0) + max_t (if t > comes then contact else 0)
    - steady * sum_t (if comes <= t and t - 2 <= comes
                      then KL(others(event); script[:t-1] || script[:t]) else 0)
