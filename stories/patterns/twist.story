# A plot twist: viewers believe one thing until the turn, and another after it.
# Chandra et al. 2023, section 3.1.2.
pattern twist(before, after, turn = T/2) =
    sum_t (if t <= turn then P(before | script[:t]) else P(after | script[:t]))
