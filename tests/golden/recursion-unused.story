pattern p(x) = q(x)
pattern q(x) = p(x)
