# Deceptive motion: viewers believe in a decoy, while the character gets what it really wants.
# Use it for a feint, a liar, a wolf in sheep's clothing.
# `who`: the deceiver. `truth`: what it really wants. `decoy`: what viewers shall believe instead.
# `scale`: what a unit of its fortune, given the truth, counts at the end. The weight grows with
# the fourth power of time, since only the end must be reached. Raise it if it never gets there.
# After Dragan, Holladay and Srinivasa 2015, DOI 10.1007/s10514-015-9458-8: exaggeration. They fix
# the end of the motion; here it is worth something.
pattern deceptive(who, truth, decoy, scale = 0.02) =
    sum_t (P(decoy | script[:t]) + scale * (t/T)^4 * E[V(who) | script[:t], truth])
