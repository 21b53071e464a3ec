# A shared secret: a friend reads in the film what a foe, who sees the same, does not believe.
# Use it for irony between viewers: what is plain to those in the know misleads the others.
# `friend`, `foe`: audiences of the story, such as `audience friend = bayesian(given = G = x)`;
# `viewers` are those that need no name. `event`: what the friend believes, and the foe does not.
# After Kulkarni, Srivastava and Kambhampati 2020, arXiv:1905.10672: one plan that is legible to
# friends and hides its goal from others, who know less.
pattern shared_secret(friend, foe, event) =
    sum_t (P[friend](event | script[:t]) - P[foe](event | script[:t]))
