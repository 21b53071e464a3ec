# Knight and ghost keep the princess from the roses together, until the knight shoves the ghost aside: from then
# on the ghost is against him.
world court
length 14

maximize twist(rho_ghost_knight > 0, rho_ghost_knight < 0, turn = when [pushes(knight, ghost)], wish = (G_princess = roses and rho_knight_princess < 0), contact = [pushes(ghost, knight) @ script[t]] + [pushes(ghost, princess) @ script[t]])
require 5 <= when [pushes(knight, ghost)] <= 9

# expect mean_t (if t <= when [pushes(knight, ghost)] then P(rho_ghost_knight > 0 | script[:t], G_princess = roses and rho_knight_princess < 0) else P(rho_ghost_knight < 0 | script[:t], G_princess = roses and rho_knight_princess < 0)) >= 0.8
# expect assume nothing: mean_t P(R_princess and R_knight and R_ghost | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
