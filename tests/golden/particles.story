world many_golden
length 5
maximize depict(rho_fox_queen > 0)
maximize mean_t E[V(bear) | script[:t]]
maximize suspense(rho_fox_queen | script[:T])
minimize entropy[few](script[:T]) - entropy(script[:T])
maximize P(rho_fox_queen > 0 @ script[1] | script[:T])
audience few = particles(count = 20)
