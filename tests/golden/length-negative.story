world kitchen
length -3
maximize 1
