# A red herring: viewers believe something false for most of the story, and then drop it.
# Use it to lead them away from what really happens; what they believe in the end is left open.
# `event`: what they believe wrongly. `dropped`: the last frame at which they do.
# After Barthes 1970, S/Z: the `snare` of the hermeneutic code.
pattern red_herring(event, dropped = 2/3 * T) =
    sum_t (if t <= dropped then P(event | script[:t]) else 1 - P(event | script[:t]))
