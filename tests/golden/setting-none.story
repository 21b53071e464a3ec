world kitchen
length 15
search naive(starts = 3)
