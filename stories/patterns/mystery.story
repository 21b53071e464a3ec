# A mystery: one question stays open, while everything else becomes clear.
# Use it to keep viewers curious. Without the facts, a story in which nothing happens would do.
# `latent`: what the question is about; it counts how much of the uncertainty at the start is left.
# `facts`: what a nat of uncertainty about everything else costs.
# After Brewer and Lichtenstein 1982, DOI 10.1016/0378-2166(82)90021-2: curiosity; and Barthes
# 1970, S/Z: the `suspended answer`.
pattern mystery(latent, facts = 0.5) =
    sum_t (entropy(latent | script[:t]) / entropy(latent | script[:0])
           - facts * (entropy(script[:t]) - entropy(latent | script[:t])))
