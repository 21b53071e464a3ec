pattern fade(event, turn = 5, over) = sum_t P(event | over[:t])
