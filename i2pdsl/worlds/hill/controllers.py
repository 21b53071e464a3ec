"""Trained controllers: policy and value networks of one training seed, as files without pickle.

One pair of networks serves all weights that it was trained for: the weight is its last input.
Those of the default hill ship with the package (`i2p train hill --seed N` made them); others lie
in the user's cache.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from i2pdsl.errors import error, shorten, whole_file
from i2pdsl.npz import read_arrays
from i2pdsl.planning.networks import Layers
from i2pdsl.resources import atomic_path, cache_folder
from i2pdsl.untrusted import json_excess
from i2pdsl.worlds.hill.hopper import MUSCLE_COUNT, NODE_COUNT, initial_state
from i2pdsl.worlds.hill.spec import HillSpec

OBSERVATION = 4 * NODE_COUNT  # numbers: the nodes' places and velocities
_LARGEST = 16 * 2**20  # bytes of a file, and of what is in it; those that ship have 140 kB
_DEEPEST = 12  # brackets in brackets of what a file says of itself
FORMAT, VERSION = "i2p-controllers", 1
SHIPPED = Path(__file__).parent / "controllers"
POSITION_SCALE = VELOCITY_SCALE = 5.0
VALUE_SCALE = 100.0


@dataclass(frozen=True)
class Controllers:
    """What one training came to.

    Attributes:
        policy: from scaled observation and weight, [77], to the actuation of the muscles, [6].
        value: from the same to the value divided by VALUE_SCALE, [1].
        weights: those that were trained, ascending.
        about: seed, physics, the command, and how well they do; informs only.
    """

    policy: Layers
    value: Layers
    weights: tuple[float, ...]
    about: dict[str, Any]


def weight_input(weights: tuple[float, ...], weight: float) -> float:
    """The networks' input for a weight: -1 for the lightest of the trained, 1 for the heaviest."""
    return 2 * (weight - weights[0]) / (weights[-1] - weights[0]) - 1


def scaling(slope: float) -> tuple[np.ndarray, np.ndarray]:
    """(offset, scale), [76] each: networks see (observation - offset) / scale."""
    x, y = initial_state(slope)[: 2 * NODE_COUNT].reshape(2, NODE_COUNT)
    offset = np.concatenate([x - x[0], y - np.tan(slope) * x[0], np.zeros(2 * NODE_COUNT)])
    scale = np.repeat([POSITION_SCALE, VELOCITY_SCALE], 2 * NODE_COUNT)
    return offset, scale


def for_weight(layers: Layers, weights: tuple[float, ...], weight: float) -> Layers:
    """The network for one weight: its last input folded into the first bias."""
    (matrix, bias), *rest = layers
    folded = bias + matrix[:, -1] * weight_input(weights, weight)
    return ((matrix[:, :-1], folded), *rest)


# Files.


def file_name(spec: HillSpec, seed: int) -> str:
    """The name of the file with the controllers of a hill and a training seed."""
    return f"{spec.name}-{spec.training_key}-seed{seed}.npz"


def save_controllers(path: Path, found: Controllers) -> None:
    """Writes controllers atomically, in single precision."""
    arrays: dict[str, np.ndarray] = {}
    for name, layers in (("policy", found.policy), ("value", found.value)):
        for number, (matrix, bias) in enumerate(layers):
            arrays[f"{name}_{number}_matrix"] = np.asarray(matrix, np.float32)
            arrays[f"{name}_{number}_bias"] = np.asarray(bias, np.float32)
    about = {"format": FORMAT, "version": VERSION, "weights": found.weights, **found.about}
    with atomic_path(path) as temporary:
        np.savez_compressed(temporary, about=np.array(json.dumps(about)), **arrays)  # type: ignore[arg-type]


def load_controllers(path: Path) -> Controllers:
    """Reads controllers. Raises ValueError for what is none, OSError where it cannot be read."""
    try:
        arrays = read_arrays(path, _LARGEST)
        about = _about(str(arrays["about"]))
        policy = _layers(arrays, "policy", MUSCLE_COUNT)
        return Controllers(policy, _layers(arrays, "value", 1), tuple(about["weights"]), about)
    except (OSError, MemoryError):
        raise
    except Exception as problem:  # zipfile and NumPy raise a dozen kinds for a damaged file
        raise ValueError(f"it is damaged ({problem})") from problem


def _about(text: str) -> dict[str, Any]:
    """What a file says of itself. Raises ValueError, KeyError or TypeError for what is wrong."""
    if json_excess(text, _DEEPEST):
        raise ValueError("what it says of itself is nested too deeply")
    about: dict[str, Any] = json.loads(text)
    if about["format"] != FORMAT or about["version"] != VERSION:
        raise ValueError(f"it is of version {shorten(str(about['version']))}, not {VERSION}")
    weights, iterations = about["weights"], about.get("iterations", 0)
    plain = all(type(w) in (int, float) and 0 < w < 1e6 for w in weights)
    if not plain or len(weights) < 2 or weights != sorted(set(weights)):
        raise ValueError("its weights are no numbers that ascend")
    if type(iterations) is not int:
        raise ValueError("its iterations are no number")
    return {**about, "weights": [float(w) for w in weights]}


def _layers(arrays: dict[str, np.ndarray], name: str, outputs: int) -> Layers:
    """A network from the observation and the weight to so many outputs. Raises ValueError."""
    count = sum(key.startswith(name) and key.endswith("matrix") for key in arrays)
    layers = []
    inputs = OBSERVATION + 1
    for i in range(count):
        matrix, bias = arrays[f"{name}_{i}_matrix"], arrays[f"{name}_{i}_bias"]
        if matrix.dtype.kind != "f" or bias.dtype.kind != "f":
            raise ValueError(f"the {name} network does not consist of numbers")
        if matrix.ndim != 2 or matrix.shape[1] != inputs or bias.shape != matrix.shape[:1]:
            raise ValueError(f"the layers of the {name} network do not fit each other")
        inputs = len(bias)
        layers.append((matrix.astype(float), bias.astype(float)))
    if not layers or not all(np.isfinite(m).all() and np.isfinite(b).all() for m, b in layers):
        raise ValueError(f"the {name} network is not there, or not finite")
    if inputs != outputs:
        raise ValueError(f"the {name} network has {inputs} outputs, not {outputs}")
    return tuple(layers)


def find_controllers(
    spec: HillSpec, seed: int, say: Callable[[str], None] | None = None
) -> Controllers:
    """The controllers of a training seed for a hill and the weights that it needs.

    Raises StoryError, naming the command that trains them, where there are none.
    """
    for path in places(spec, seed):
        try:
            found = load_controllers(path)
        except FileNotFoundError:
            continue
        except OSError as problem:
            reason = problem.strerror or str(problem)
        except ValueError as problem:
            reason = str(problem)
        else:
            if found.weights == spec.trained_weights:
                return found
            reason = "they were trained for other weights"
        if say is not None:
            say(f"the controllers {path} cannot be used: {reason}")
    shown = ", ".join(f"{w:g}" for w in spec.trained_weights)
    message = f"no controllers are trained for this hill (weights {shown}; training seed {seed})"
    command = training_command(spec, seed)
    raise error("training", message, whole_file(f"world {spec.name}"), f"train them: `{command}`")


def places(spec: HillSpec, seed: int) -> list[Path]:
    """Where the file can lie: one's own first."""
    name = file_name(spec, seed)
    found = [SHIPPED / name]
    with suppress(OSError):
        found.insert(0, cache_folder("controllers") / name)
    return found


def controllers_version(spec: HillSpec) -> tuple[tuple[str, int], ...]:
    """Another one for other files: the places that have one, with their times of change."""
    found = []
    for path in places(spec, spec.settings.controller):
        with suppress(OSError):
            found.append((str(path), path.stat().st_mtime_ns))
    return tuple(found)


def _plain(number: float) -> str:
    """A number with all its digits, and none that it does not need."""
    return str(number).removesuffix(".0")


def training_command(spec: HillSpec, seed: int, iterations: int | None = None) -> str:
    """The command that trains what a hill needs; `iterations` where they are not the usual."""
    parts = [f"i2p train {spec.name}"]
    changed = spec.changed_settings()
    parts += [f"--set {name}={_plain(changed[name])}" for name in spec.physics if name in changed]
    if spec.trained_weights != HillSpec().trained_weights:
        shown = ",".join(map(_plain, spec.trained_weights))
        parts.append(f"--set 'weights={{{shown}}}'")  # shells have a meaning for braces
    parts.append(f"--seed {seed}")
    if iterations is not None:
        parts.append(f"--iterations {iterations}")
    return " ".join(parts)
