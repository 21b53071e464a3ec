world broken_golden
length 15
maximize 1
