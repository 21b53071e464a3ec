  world kitchen
length 15
maximize 1
