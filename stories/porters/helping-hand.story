# A loader that helps the carrier: viewers shall believe it from the first frame to the last.
world porters
length 12

maximize depict(rho > 0)

# expect mean_t P(rho > 0 | script[:t]) >= 0.94
# expect assume nothing: mean_t P(R_carrier and R_loader | script[:t]) >= 0.94
# expect still <= 0.34
