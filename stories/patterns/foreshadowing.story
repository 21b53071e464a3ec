# Foreshadowing: nobody expects it; an early hint is half believed; then it comes true.
# Use it to prepare a turn, so that it is felt to be earned when it comes.
# `event`: what comes true. `hint`: the frame of the hint, before which viewers shall not believe
# in the event. `comes`: the last frame before it comes true. Half belief is 4 p (1 - p), which is
# 1 at p = 1/2 and 0 where viewers are certain.
# After Bae and Young 2008, A use of flashback and foreshadowing for surprise arousal.
pattern foreshadowing(event, hint = T/4, comes = 3/4 * T) =
    sum_t (if t < hint then 1 - P(event | script[:t])
           else if t <= comes then 4 * P(event | script[:t]) * (1 - P(event | script[:t]))
           else P(event | script[:t]))
