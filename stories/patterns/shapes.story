# Rags to riches: a character's fortune rises from the first frame to the last.
# Use it for a simple happy tale.
# `who`: whose fortune. `wish`: what everybody knows that it wants, such as `G = x`. `scale`: what a
# unit of fortune counts. `steady`: what a nat of changed beliefs costs. See `arc`.
# After Reagan et al. 2016, DOI 10.1140/epjds/s13688-016-0093-1: the first of six shapes, `rise`.
pattern rags_to_riches(who, wish = 1 = 1, scale = 0.02, steady = 0.1) =
    arc(who, -cos(pi * t/T), scale, steady, wish)

# Riches to rags: a character's fortune falls from the first frame to the last; a tragedy.
# Use it for a simple sad tale.
# `who`: whose fortune. `wish`: what everybody knows that it wants, such as `G = x`. `scale`: what a
# unit of fortune counts. `steady`: what a nat of changed beliefs costs. See `arc`.
# After Reagan et al. 2016, DOI 10.1140/epjds/s13688-016-0093-1: `fall`.
pattern riches_to_rags(who, wish = 1 = 1, scale = 0.02, steady = 0.1) =
    arc(who, cos(pi * t/T), scale, steady, wish)

# Man in a hole: a character gets into trouble, and gets out of it again.
# Use it for a comedy, or an adventure that ends well.
# `who`: whose fortune. `wish`: what everybody knows that it wants, such as `G = x`. `scale`: what a
# unit of fortune counts. `steady`: what a nat of changed beliefs costs. See `arc`.
# After Vonnegut; Reagan et al. 2016, DOI 10.1140/epjds/s13688-016-0093-1: `fall-rise`.
pattern man_in_a_hole(who, wish = 1 = 1, scale = 0.02, steady = 0.1) =
    arc(who, cos(2*pi * t/T), scale, steady, wish)

# Icarus: a character rises, and falls when it is nearly there.
# Use it for a hope that is dashed.
# `who`: whose fortune. `wish`: what everybody knows that it wants, such as `G = x`. `scale`: what a
# unit of fortune counts. `steady`: what a nat of changed beliefs costs. See `arc`.
# After Reagan et al. 2016, DOI 10.1140/epjds/s13688-016-0093-1: `rise-fall`.
pattern icarus(who, wish = 1 = 1, scale = 0.02, steady = 0.1) =
    arc(who, -cos(2*pi * t/T), scale, steady, wish)

# Cinderella: a character rises, falls, and rises for good.
# Use it for a happiness that is lost once before it lasts.
# `who`: whose fortune. `wish`: what everybody knows that it wants, such as `G = x`. `scale`: what a
# unit of fortune counts. `steady`: what a nat of changed beliefs costs. See `arc`.
# After Reagan et al. 2016, DOI 10.1140/epjds/s13688-016-0093-1: `rise-fall-rise`.
pattern cinderella(who, wish = 1 = 1, scale = 0.02, steady = 0.1) =
    arc(who, -cos(3*pi * t/T), scale, steady, wish)

# Oedipus: a character falls, recovers, and falls for good.
# Use it for a rescue that does not last.
# `who`: whose fortune. `wish`: what everybody knows that it wants, such as `G = x`. `scale`: what a
# unit of fortune counts. `steady`: what a nat of changed beliefs costs. See `arc`.
# After Reagan et al. 2016, DOI 10.1140/epjds/s13688-016-0093-1: `fall-rise-fall`.
pattern oedipus(who, wish = 1 = 1, scale = 0.02, steady = 0.1) =
    arc(who, cos(3*pi * t/T), scale, steady, wish)
