# A hand reaches for the right cup, and takes the left one: a feint.
world desk
length 64

maximize deceptive(hand, G_hand = left, G_hand = right, scale = 3)

# expect mean_{t in 1..32} P(G_hand = right | script[:t]) >= 0.8
# expect [at(hand, left) @ script[T]] >= 1
# expect assume nothing: mean_t P(R_hand | script[:t]) >= 0.8
