"""What exact planning of a grid world takes, told from its file. No arrays here."""

from __future__ import annotations

from i2pdsl.sizes import memory_limit
from i2pdsl.worlds.grid.hypotheses import grid_hypotheses
from i2pdsl.worlds.grid.spec import GridSpec

PATIENCE = 600.0  # seconds of exact planning above which `auto` is additive
# What a sweep takes for each state and problem (measured: the kitchen, two cores), and how many
# there are for each 1 / (1 - gamma).
SWEEP_SECONDS, SWEEPS = 1.2e-8, 1.5


def planning_bytes(spec: GridSpec, problems: int) -> int:
    """Memory that planning takes at its peak: tables, values and their copies (measured)."""
    each = state_bytes(problems)
    if spec.settings.horizon:  # the values of every frame, and their copy on the device
        each += 8 * spec.frame_count * problems
    return 2**26 + spec.state_count * each + 4 * listed_arrangements(spec)


def state_bytes(problems: int) -> int:
    """What planning holds of each state: its values, its rewards and policies in the groups, and
    its successors."""
    return 100 * problems + 500


def planning_seconds(spec: GridSpec, problems: int) -> float:
    """How long planning takes, roughly."""
    sweeps = SWEEPS * spec.frame_count / (1 - spec.settings.gamma)
    return SWEEP_SECONDS * spec.state_count * problems * len(spec.characters) * sweeps


def listed_arrangements(spec: GridSpec) -> int:
    """The length of the table of all arrangements, valid or not (Dynamics.lookup)."""
    return 0 if spec.is_sparse else spec.arrangement_count


def is_brief(spec: GridSpec, problems: int) -> bool:
    """Whether exact plans of so many problems fit into the memory, and do not take long."""
    in_time = planning_seconds(spec, problems) <= PATIENCE
    return in_time and planning_bytes(spec, problems) <= memory_limit()


def is_plainly_brief(spec: GridSpec) -> bool:
    """Whether they do however its hypotheses share their problems."""
    return is_brief(spec, len(spec.characters) * len(grid_hypotheses(spec)))
