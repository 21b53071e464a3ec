world kitchen
length 15
start absent(robot) and absent(tabel)
maximize 1
