# The robot's fortune rises, falls and rises again; a table may fall from the sky.
world kitchen
length 25
start absent(table)
allow deus(table)

maximize arc(robot)
