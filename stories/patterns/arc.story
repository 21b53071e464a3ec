# A narrative arc: a character's fortune, as viewers see it, follows a shape over time, while
# their beliefs stay steady.
# Use it to plan a whole story by its ups and downs. Six common shapes have names of their own.
# `who`: whose fortune; what this character can still hope for, by its value function.
# `shape`: where it shall be high (above 0) and where low; `points((0, 0), (1, 1))` draws one.
# `scale`: what one unit of fortune counts. `steady`: what a nat of changed beliefs costs.
# `wish`: what everybody knows that the character wants, such as `G = x`; without it, a changed
# mind counts as a changed fortune.
# After Vonnegut; Chandra et al. 2023, DOI 10.1145/3588432.3591510, section 3.1.5.
pattern arc(who, shape = sin(t/T * 3*pi), scale = 0.02, steady = 0.1, wish = 1 = 1) =
    sum_t (scale * shape * E[V(who) | script[:t], wish] - steady * KL(script[:t-1] || script[:t]))
