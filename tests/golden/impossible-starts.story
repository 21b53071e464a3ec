world kitchen
length 15
start absent(table)
start adjacent(table, robot)
maximize 1
