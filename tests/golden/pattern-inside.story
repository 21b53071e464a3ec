world kitchen
length 15
# Fades in.
pattern fade(event) =
    sum_t t/T * P(event | script[:t]) + roh

maximize fade(rho > 0)
