# Knight and ghost both want to bring the princess where she wants to go, and the ghost will not have the
# knight do it.
world court
length 12

maximize depict(rho_knight_princess > 0 and rho_ghost_princess > 0 and rho_ghost_knight < 0)

# expect mean_t P(rho_knight_princess > 0 and rho_ghost_princess > 0 and rho_ghost_knight < 0 | script[:t]) >= 0.9
# expect assume nothing: mean_t P(R_princess and R_knight and R_ghost | script[:t]) >= 0.9
# expect still <= 0.25
# expect luck <= 2.5
