world kitchen
length 15
maximize 1
search descend
