# The knight passes for the princess's friend, and is not; her true friend steps between them.
world court
length 14

maximize twist(rho_knight_princess > 0, rho_knight_princess < 0, wish = (G_princess = roses), contact = 2 * [pushes(knight, princess) @ script[t]])
    + sum_t (if t <= T/2 then P(rho_ghost_princess > 0 | script[:t], G_princess = roses)
             else P(rho_ghost_princess > 0 and rho_ghost_knight < 0 | script[:t], G_princess = roses))

# expect mean_t (if t <= T/2 then P(rho_knight_princess > 0 | script[:t], G_princess = roses) else P(rho_knight_princess < 0 | script[:t], G_princess = roses)) >= 0.9
# expect P(rho_ghost_princess > 0 and rho_ghost_knight < 0 | script[:T], G_princess = roses) >= 0.9
# expect assume nothing: mean_t P(R_princess and R_knight and R_ghost | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
