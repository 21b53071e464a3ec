world kitchen
length 15
import "mine
maximize 1
