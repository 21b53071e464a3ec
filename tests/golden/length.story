world kitchen
length 0
maximize 1
