# A plot twist: viewers believe one thing until the turn, and another after it.
# Use it to turn a friend into a foe, or the other way round, at a moment of your choice.
# `before`, `after`: what they believe. `turn`: the last frame of the first belief.
# After Chandra et al. 2023, DOI 10.1145/3588432.3591510, section 3.1.2.
pattern twist(before, after, turn = T/2) =
    sum_t (if t <= turn then P(before | script[:t]) else P(after | script[:t]))
