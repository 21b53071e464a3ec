# A plot twist: viewers believe one thing until the turn, and another after it.
# Use it to turn a friend into a foe, or the other way round, at a moment of your choice: a
# betrayal, a change of heart, one who seems to help and then hinders.
# `before`, `after`: what they believe. `turn`: the last frame of the first belief.
# `wish`: what everybody knows all along, such as what the other one wants, `G = x`.
# `steady`: what a nat of changed beliefs about anything else costs around the turn: the
# friend shall become a foe, and the other one go on wanting the same.
# `contact`: what shall be seen before and after it, such as `[adjacent(a, b) @ script[t]]`.
# After Chandra et al. 2023, DOI 10.1145/3588432.3591510, section 3.1.2.
pattern twist(before, after, turn = T/2, wish = 1 = 1, steady = 0.5, contact = 0) =
    sum_t (if t <= turn then P(before | script[:t], wish) else P(after | script[:t], wish))
    + max_t (if t <= turn then contact else 0) + max_t (if t > turn then contact else 0)
    - steady * sum_t (if turn <= t and t - 2 <= turn
                      then KL(others(before, after); script[:t-1] || script[:t]) else 0)
