world hill(will = meek, lazy = 2)
length 10
maximize P(will = eager | script[:T])
