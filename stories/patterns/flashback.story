# A flashback: a last picture is given, and what came before it shows how to understand it.
# Use it to give a moment that viewers may know already another meaning.
# `event`: what they shall believe, from the first frame to the given one.
# `shown`: the script with the given turns, `script ++ [...]`. `picture`: what is to be seen in its
# last frame, such as a push.
# After Chandra et al. 2023, DOI 10.1145/3588432.3591510, section 3.1.4.
pattern flashback(event, shown, picture) =
    depict(event, over = shown) + [picture @ shown[last(shown)]]
