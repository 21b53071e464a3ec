# Knight and ghost keep the princess from the roses together, until the ghost turns against the knight.
world court
length 14

maximize twist(rho_ghost_knight > 0, rho_ghost_knight < 0, wish = (G_princess = roses and rho_knight_princess < 0), contact = [pushes(ghost, knight) @ script[t]] + [pushes(ghost, princess) @ script[t]])

# expect mean_t (if t <= T/2 then P(rho_ghost_knight > 0 | script[:t], G_princess = roses and rho_knight_princess < 0) else P(rho_ghost_knight < 0 | script[:t], G_princess = roses and rho_knight_princess < 0)) >= 0.8
# expect assume nothing: mean_t P(R_princess and R_knight and R_ghost | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
