# Show something all the way: viewers shall believe the event after every frame.
# Use it to make plain what somebody is like, or wants.
# `event`: what they shall believe. `over`: the script that they see, for one with turns appended.
# After Chandra et al. 2023, DOI 10.1145/3588432.3591510, section 3.1.1.
pattern depict(event, over = script) = sum_{t in 1..last(over)} P(event | over[:t])
