# Show something all the way: viewers shall believe the event after every frame.
# Chandra et al. 2023, section 3 (character).
pattern depict(event, over = script) = sum_{t in 1..last(over)} P(event | over[:t])
