# Not a golden itself: a library with mistakes, for import-library.
world kitchen
pattern fade(event) = sum_t P(event | script[:t)
pattern fade2(event) = sum_t P(event | script[:t])
