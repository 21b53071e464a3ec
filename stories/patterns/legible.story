# Legible motion: viewers know early what the character is up to.
# Use it where an intention shall be clear at first sight, before anything is achieved.
# `event`: what they shall know. A frame counts the more the earlier it is, falling from 2 at the
# start to 0 at the end, 1 on average.
# After Dragan, Lee and Srinivasa 2013, DOI 10.1109/HRI.2013.6483603: their weight T - t.
pattern legible(event) = sum_t ((2 * (T - t) + 1) / T * P(event | script[:t]))
