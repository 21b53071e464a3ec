# Sally and Anne (Baron-Cohen, Leslie and Frith 1985): Anne puts Sally's ball into the box while Sally is
# not there. Sally comes back, and looks for it in the basket.
world nursery
length 13

maximize depict(believes(sally, at(ball, basket)))
require [at(ball, box) @ script[6]]

# expect mean_{t in 8..13} P(believes(sally, at(ball, basket)) | script[:t]) >= 0.95
# expect [at(sally, basket) @ script[T]] >= 1
# expect assume nothing: mean_t P(R_sally and R_anne | script[:t]) >= 0.9
# expect still <= 0.3
