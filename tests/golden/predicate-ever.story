world hill
length 50
maximize mean_t P(weight = 0.5, when [fallen(hopper)] < 3 | script[:t])
maximize mean_t P(weight = 0.5 and when [fallen(hopper)] < 3 | script[:t])
maximize when [progress(box)]
require never [fallen(hopper) and t > 3]
maximize P(weight = 0.5 | script[:when [fallen(hopper)]])
