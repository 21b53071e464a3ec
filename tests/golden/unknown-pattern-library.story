pattern p(x) = foo(x)
pattern q(x) = depict(x, x, x)
pattern r(x) = sum_t [progress(x) @ script[t]]
