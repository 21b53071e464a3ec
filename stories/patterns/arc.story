# A narrative arc: a character's fortune, as viewers see it, follows a shape over time, while
# their beliefs stay steady. Chandra et al. 2023, section 3.1.5, after Vonnegut.
pattern arc(who, shape = sin(t/T * 3*pi), scale = 0.02, steady = 0.1) =
    sum_t (scale * shape * E[V(who) | script[:t]] - steady * KL(script[:t-1] || script[:t]))
