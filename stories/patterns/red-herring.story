# A red herring: viewers believe something false for most of the story, and then drop it.
# Use it to lead them away from what really happens; what they believe in the end is left open.
# `event`: what they believe wrongly. `dropped`: the last frame at which they do.
# `wish`: what everybody knows all along, such as what the other one wants, `G = x`.
# `steady`: what a nat of changed beliefs about anything else costs around that frame.
# `contact`: what shall be seen before and after it, such as `[adjacent(a, b) @ script[t]]`.
# After Barthes 1970, S/Z: the `snare` of the hermeneutic code.
pattern red_herring(event, dropped = 2/3 * T, wish = 1 = 1, steady = 0.5, contact = 0) =
    sum_t (if t <= dropped then P(event | script[:t], wish) else 1 - P(event | script[:t], wish))
    + max_t (if t <= dropped then contact else 0) + max_t (if t > dropped then contact else 0)
    - steady * sum_t (if dropped <= t and t - 2 <= dropped
                      then KL(others(event); script[:t-1] || script[:t]) else 0)
