# Dramatic irony: viewers know the truth, and see that someone acts on a mistake.
# They believe `truth`; given the truth the deed is `done`, given what was mistaken for it the
# deed is what was `meant`. Chandra et al. 2023, section 3.1.3.
pattern irony(truth, mistaken, meant, done) =
    sum_t (P(truth | script[:t])
           + P(done | script[:t], truth)
           + P(meant | script[:t], mistaken))
