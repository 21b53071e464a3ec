# A hand reaches for the left cup so that everybody knows early which one it is.
# Dragan and Srinivasa 2013: it swerves away from the other.
world desk
length 60

maximize legible(G_hand = left)
maximize 10 * [at(hand, left) @ script[T]]

# expect mean_{t in 1..20} P(G_hand = left | script[:t]) >= 0.9
# expect [at(hand, left) @ script[T]] >= 1
# expect assume nothing: mean_t P(R_hand | script[:t]) >= 0.9
