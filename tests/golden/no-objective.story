world kitchen
length 15
