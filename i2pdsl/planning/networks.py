"""Small feed-forward networks as plain arrays, in NumPy or JAX."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

Array = Any
Layers = tuple[tuple[Array, Array], ...]
"""(matrix [out, in], bias [out]) of each layer."""


def apply_network(layers: Layers, inputs: Array) -> Array:
    """ELU between the layers, linear at the end: [in, B] -> [out, B].

    Source: Clevert et al. 2016 (arXiv:1511.07289) for the ELU.
    """
    xp = inputs.__array_namespace__()
    *hidden, (matrix, bias) = layers
    for inner, offset in hidden:
        inputs = inner @ inputs + offset[..., None]
        inputs = xp.where(inputs > 0, inputs, xp.expm1(xp.minimum(inputs, 0.0)))
    return matrix @ inputs + bias[..., None]


def random_network(
    generator: np.random.Generator, sizes: tuple[int, ...], last_scale: float = 1.0
) -> Layers:
    """Orthogonal matrices (gain sqrt 2 where an ELU follows) and no biases, in single precision."""
    layers = []
    for number, (inputs, outputs) in enumerate(pairwise(sizes)):
        gain = last_scale if number == len(sizes) - 2 else np.sqrt(2.0)
        size = max(inputs, outputs)
        basis, triangle = np.linalg.qr(generator.normal(size=(size, size)))
        basis = basis * np.sign(np.diag(triangle))
        matrix = (gain * basis[:outputs, :inputs]).astype(np.float32)
        layers.append((matrix, np.zeros(outputs, np.float32)))
    return tuple(layers)
