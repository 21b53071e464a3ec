# A loader that helps the carrier: viewers shall believe it from the first frame to the last.
world porters
length 12

maximize depict(rho > 0)
