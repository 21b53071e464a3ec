# A robot that helps the cheese: viewers shall believe so from the first frame to the last.
world kitchen
length 15

maximize depict(rho > 0)
