# Surprise: what viewers believe moves far, from frame to frame.
# Use it for one turn after another. Nothing limits how often belief swings but the characters'
# good sense, so a larger `rationality` makes fewer and better turns.
# `event`: what they change their minds about.
# After Ely, Frankel and Kamenica 2015, DOI 10.1086/677350, section II: the distance of belief from
# that of a period ago. It is the square root of the squared distance, their baseline utility; the
# root 2 for an event and its opposite is left out, so that a complete change of mind counts 1.
pattern surprising(event) = sum_t abs(P(event | script[:t]) - P(event | script[:t-1]))
