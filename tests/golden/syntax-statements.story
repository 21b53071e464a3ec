world kitchen length 15
length
maximize
