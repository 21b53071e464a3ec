world kitchen
length 1.5
maximize 1
