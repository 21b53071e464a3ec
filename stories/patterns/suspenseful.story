# Suspense: at every moment viewers expect that the next frame will tell them much.
# Use it before a decision. Suspense is high while the answer is near, and is spent when it comes.
# `latent`: what the next frame may tell about.
# After Ely, Frankel and Kamenica 2015, DOI 10.1086/677350, section II: the variance of the next
# belief, and the square root as their baseline utility. The root makes it a standard deviation,
# at most 1 a frame as other beliefs are, and likes lasting suspense better than one great moment.
# Viewers expect to learn no more than there is to know: sqrt((1 - 1/n) / T) a frame on the average
# film, n values over T frames. A film that has more of it makes them doubt anew.
# Suspense after the last frame counts too: viewers do not know that it is the last.
pattern suspenseful(latent) = sum_t sqrt(suspense(latent | script[:t]))
