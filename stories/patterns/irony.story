# Dramatic irony: viewers know the truth, and see that someone acts on a mistake.
# Use it where the audience shall know more than a character: a kindness that does harm, say.
# `truth`: what viewers believe. `mistaken`: what the character takes for the truth.
# `meant`: what the deed would be if the mistake were true. `done`: what it is in truth.
# After Chandra et al. 2023, DOI 10.1145/3588432.3591510, section 3.1.3.
pattern irony(truth, mistaken, meant, done) =
    sum_t (P(truth | script[:t])
           + P(done | script[:t], truth)
           + P(meant | script[:t], mistaken))
