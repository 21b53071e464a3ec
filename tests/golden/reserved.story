world kitchen
length 15
let P = 3
let pi = 3
pattern show(t) = 1
maximize 2 * then
