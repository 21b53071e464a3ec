world kitchen
length 15
maximize sum_{t in 5..1} 1
maximize sum_{t in -1..5} 1
maximize sum_{t in 1..50} 1
maximize sum_{t in 1..5000} 1
