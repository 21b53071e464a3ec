"""A hill as data: its numbers, and what stories may replace of them (model.md, "Hill").
No arrays and no JAX: the checker needs only this."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field, replace
from itertools import product
from typing import Any, ClassVar

NAME = "hill"
EAGER, LAZY = "eager", "lazy"  # of the will: to do one's best, or less
DOCUMENTATION = """A hopper of masses and springs pulls a box up a slope.
How much the box weighs, viewers infer from how the hopper moves."""


@dataclass(frozen=True)
class HillSettings:
    """The numbers of a hill that a story may replace: `world hill(weight = 0.5)`."""

    weight: float = 0.1  # of the box, as it is
    weights: tuple[float, ...] = (0.1, 0.5)  # what viewers think it could be
    will: str = EAGER  # of the hopper, as it is
    lazy: float = 1.0  # the share of its actuation that a lazy hopper uses; 1: nobody is lazy
    slope: float = 0.1  # radians
    gravity: float = 1.2
    friction: float = 0.3  # Coulomb's coefficient of the hopper's feet
    box_friction: float = 1.5
    node_mass: float = 10.0  # of the hopper's nodes; those of the box have this times the weight
    foot_mass: float = 50.0
    controller: int = 2  # the training seed of the networks that act
    sigma: float = 1.0  # how exactly viewers compare what they see with what they imagine
    forgetting: float = 1e-5  # the share of belief that is reassigned after each frame
    evidence: str = "motion"  # motion | mass: whether viewers imagine the muscles or know them


_PHYSICS = ("slope", "gravity", "friction", "box_friction", "node_mass", "foot_mass")


@dataclass(frozen=True)
class HillSpec:
    """A hill with its settings."""

    kind: ClassVar[str] = NAME
    settings: HillSettings = field(default_factory=HillSettings)
    name: str = NAME
    documentation: str = DOCUMENTATION

    @property
    def source(self) -> str:
        """Hills come from no .world file."""
        return ""

    def with_settings(self, changes: dict[str, Any]) -> HillSpec:
        """The same hill with some of its numbers replaced."""
        if "controller" in changes:
            changes = {**changes, "controller": int(changes["controller"])}
        if "weights" in changes:
            changes = {**changes, "weights": tuple(sorted(map(float, changes["weights"])))}
        return replace(self, settings=replace(self.settings, **changes))

    @property
    def wills(self) -> tuple[str, ...]:
        """What viewers think the hopper's will could be."""
        return (EAGER, LAZY) if self.settings.lazy < 1 else (EAGER,)

    @property
    def hypotheses(self) -> tuple[tuple[float, str], ...]:
        """What viewers think could be true: a weight and a will each."""
        return tuple(product(self.settings.weights, self.wills))

    def share(self, will: str) -> float:
        """How much of its controller's actuation a hopper of a will uses."""
        return self.settings.lazy if will == LAZY else 1.0

    @property
    def trained_weights(self) -> tuple[float, ...]:
        """The weights that controllers must know: the true one and those that viewers imagine."""
        return tuple(sorted({self.settings.weight, *self.settings.weights}))

    @property
    def physics(self) -> dict[str, float]:
        """The numbers that training depends on, besides the weights."""
        numbers = asdict(self.settings)
        return {name: float(numbers[name]) for name in _PHYSICS}

    @property
    def training_settings(self) -> tuple[str, ...]:
        """The settings that decide which controllers are trained."""
        return ("weight", "weights", "controller", *_PHYSICS)

    @property
    def training_key(self) -> str:
        """A digest of all that training depends on, besides the seed."""
        content = {"physics": self.physics, "weights": self.trained_weights}
        text = json.dumps(content, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def changed_settings(self) -> dict[str, Any]:
        """The settings that differ from the default hill."""
        usual = asdict(HillSettings())
        return {k: v for k, v in asdict(self.settings).items() if v != usual[k]}
