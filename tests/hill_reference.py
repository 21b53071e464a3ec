"""The equations of the hill, with plain floats and loops.

An independent transcription of design/model.md ("Hill (physics)", and the forgetting of "Kitchen").
It imports nothing of the package, and the package is tested against it. The order here is that of
the text: the body, one frame, the reward, what is observed, the networks, the audience.

A state is a list of 19 nodes (x, y, vx, vy). `numbers` are the fields of Numbers, by keyword. The
slope is the line through the origin that rises by `slope` radians towards +x.
"""

import math
from dataclasses import dataclass
from typing import Any

Node = tuple[float, float, float, float]  # x, y, vx, vy
State = list[Node]
Layer = tuple[list[list[float]], list[float]]  # matrix rows (one per output), biases


@dataclass(frozen=True)
class Numbers:
    slope: float = 0.1  # rad
    gravity: float = 1.2  # straight down, not across the slope
    friction: float = 0.3
    box_friction: float = 1.5
    node_mass: float = 10.0
    foot_mass: float = 50.0
    stiffness: float = 500.0
    rope_stiffness: float = 100.0
    damping: float = 20.0
    dt: float = 0.0125
    substeps: int = 4


CLIP = 1.0  # the largest extension that counts
CONTACT = 2000.0  # normal force per depth
STROKE = 0.25  # the largest relative change of a muscle's rest length
POWER_CHARGE = 9 / 100
FALLEN = 5.0  # the episode ends when the head is lower
FORGETTING = 1e-5

# ---- The body ------------------------------------------------------------------------------------

LISTED = [
    # the hopper: nodes 0 to 10
    (-0.8, -0.8),
    (0.8, -0.8),
    (0.0, 0.0),
    (-0.4, 0.5),
    (0.4, 0.5),
    (0.0, 1.0),
    (-0.4, 1.5),
    (0.4, 1.5),
    (0.0, 2.0),
    (-0.4, 2.5),
    (0.4, 2.5),
    # the box: nodes 11 to 18
    (-3.0, -1.0),
    (-3.0, 0.0),
    (-4.0, -1.0),
    (-4.0, 0.0),
    (-5.0, -1.0),
    (-5.0, 0.0),
    (-6.0, -1.0),
    (-6.0, 0.0),
]
REST = [(5 * (x - 4), 4 * (y + 0.4)) for x, y in LISTED]
HOPPER, BOX, FEET = range(11), range(11, 19), (0, 1)
HEAD = 9


def _pairs(text: str) -> list[tuple[int, int]]:
    """'0-1 1-2' -> [(0, 1), (1, 2)]"""
    return [(int(a), int(b)) for a, b in (pair.split("-") for pair in text.split())]


BONES = _pairs("0-1 1-2 0-2  2-3 2-4 3-4  3-5 4-5  5-6 5-7 6-7  6-8 7-8  8-9 8-10 9-10")
MUSCLES = _pairs("0-3 3-6 6-9 1-4 4-7 7-10")
BOX_SPRINGS = _pairs(
    "11-12 11-13 11-14 12-13 12-14 13-14 13-15 13-16 14-15 14-16 15-16"
    " 15-17 15-18 16-17 16-18 17-18"
)
ROPE = (6, 12)
SPRINGS = [*BONES, *MUSCLES, *BOX_SPRINGS, ROPE]
assert len(REST) == 19
assert len(SPRINGS) == len(set(SPRINGS)) == 39
REST_LENGTHS = {(i, j): math.dist(REST[i], REST[j]) for i, j in SPRINGS}


def masses(weight: float, **numbers: Any) -> list[float]:
    """Of the 19 nodes: the box's are `weight` times those of the hopper."""
    n = Numbers(**numbers)
    return [
        n.foot_mass if i in FEET else n.node_mass * weight if i in BOX else n.node_mass
        for i in range(19)
    ]


def frictions(**numbers: Any) -> list[float]:
    """Coulomb's mu of the 19 nodes."""
    n = Numbers(**numbers)
    return [n.box_friction if i in BOX else n.friction for i in range(19)]


def stiffness_of(spring: tuple[int, int], **numbers: Any) -> float:
    """The spring constant of one of SPRINGS."""
    n = Numbers(**numbers)
    return n.rope_stiffness if spring == ROPE else n.stiffness


def rest_length(spring: tuple[int, int], actuation: list[float]) -> float:
    """That of a muscle is times 1 + 0.25 tanh a."""
    length = REST_LENGTHS[spring]
    if spring in MUSCLES:
        length *= 1 + STROKE * math.tanh(actuation[MUSCLES.index(spring)])
    return length


def initial() -> State:
    """At rest."""
    return [(x, y, 0.0, 0.0) for x, y in REST]


# ---- One frame -----------------------------------------------------------------------------------


def direction(state: State, i: int, j: int) -> tuple[float, float]:
    """The unit vector from node i to node j."""
    (xi, yi, _, _), (xj, yj, _, _) = state[i], state[j]
    length = math.hypot(xj - xi, yj - yi)
    return (xj - xi) / length, (yj - yi) / length


def tension(state: State, spring: tuple[int, int], actuation: list[float], **numbers: Any) -> float:
    """What pulls the ends together: elastic (clipped) plus damping times the rate of lengthening.

    Negative where the spring pushes; the rope may push too.
    """
    n, (i, j) = Numbers(**numbers), spring
    (xi, yi, vxi, vyi), (xj, yj, vxj, vyj) = state[i], state[j]
    ux, uy = direction(state, i, j)
    extension = math.hypot(xj - xi, yj - yi) - rest_length(spring, actuation)
    clipped = min(max(extension, -CLIP), CLIP)
    rate = (vxj - vxi) * ux + (vyj - vyi) * uy
    return stiffness_of(spring, **numbers) * clipped + n.damping * rate


def depth(x: float, y: float, slope: float) -> float:
    """How far a point lies under the slope, measured perpendicular to it; 0 above."""
    return max(x * math.sin(slope) - y * math.cos(slope), 0.0)


def substep(
    state: State, actuation: list[float], weight: float, **numbers: Any
) -> tuple[State, float]:
    """(next state, rope power): forces on the velocity, then friction on it, then the position.

    All forces and the rope power are those at the start of the substep.
    """
    n = Numbers(**numbers)
    mass, mu = masses(weight, **numbers), frictions(**numbers)
    along = math.cos(n.slope), math.sin(n.slope)  # up the slope
    normal = -math.sin(n.slope), math.cos(n.slope)  # out of the slope

    fx, fy = [0.0] * 19, [-m * n.gravity for m in mass]
    for i, j in SPRINGS:
        pull = tension(state, (i, j), actuation, **numbers)
        ux, uy = direction(state, i, j)
        fx[i] += pull * ux
        fy[i] += pull * uy
        fx[j] -= pull * ux
        fy[j] -= pull * uy

    following = []
    for i, (x, y, vx, vy) in enumerate(state):
        support = CONTACT * depth(x, y, n.slope)
        vx += n.dt * (fx[i] + support * normal[0]) / mass[i]
        vy += n.dt * (fy[i] + support * normal[1]) / mass[i]
        slide = vx * along[0] + vy * along[1]
        slower = max(abs(slide) - mu[i] * support * n.dt / mass[i], 0.0)
        change = math.copysign(slower, slide) - slide
        vx += change * along[0]
        vy += change * along[1]
        following.append((x + n.dt * vx, y + n.dt * vy, vx, vy))

    hopper_end, box_end = ROPE
    ux, uy = direction(state, box_end, hopper_end)
    _, _, vx, vy = state[box_end]
    power = tension(state, ROPE, actuation, **numbers) * (vx * ux + vy * uy)
    return following, power


def step(
    state: State, actuation: list[float], weight: float, **numbers: Any
) -> tuple[State, float]:
    """(next state, rope power): one frame; the power is the mean over its substeps."""
    n, total = Numbers(**numbers), 0.0
    for _ in range(n.substeps):
        state, power = substep(state, actuation, weight, **numbers)
        total += power
    return state, total / n.substeps


def energy(state: State, weight: float, **numbers: Any) -> float:
    """Kinetic, of gravity, elastic (muscles relaxed) and of the contact.

    Of a spring: quadratic up to the clipped extension, linear beyond.
    """
    n, total = Numbers(**numbers), 0.0
    for m, (x, y, vx, vy) in zip(masses(weight, **numbers), state, strict=True):
        total += m * (vx**2 + vy**2) / 2 + m * n.gravity * y
        total += CONTACT / 2 * depth(x, y, n.slope) ** 2
    for i, j in SPRINGS:
        stretch = abs(math.dist(state[i][:2], state[j][:2]) - REST_LENGTHS[i, j])
        beyond = max(stretch - CLIP, 0.0)
        total += stiffness_of((i, j), **numbers) * (min(stretch, CLIP) ** 2 / 2 + CLIP * beyond)
    return total


# ---- The reward ----------------------------------------------------------------------------------


def head_height(state: State, slope: float = Numbers.slope) -> float:
    """y of node 9 minus tan(slope) times x of node 0; the hopper has fallen where it is below 5."""
    return state[HEAD][1] - math.tan(slope) * state[0][0]


def reward(
    next_state: State, actuation: list[float], power: float, weight: float, **numbers: Any
) -> float:
    """Of the frame that ended in `next_state`.

    head height + 0.5 mean(v_x m) - 0.1 mean(v^2) - 0.1 mean(a^2) - 9 P / 100, means over the hopper
    (and over the six muscles); `weight` plays no part but through the power.
    """
    mass = masses(weight, **numbers)
    momentum = sum(mass[i] * next_state[i][2] for i in HOPPER) / len(HOPPER)
    speed2 = sum(next_state[i][2] ** 2 + next_state[i][3] ** 2 for i in HOPPER) / len(HOPPER)
    effort = sum(a**2 for a in actuation) / len(actuation)
    return (
        head_height(next_state, Numbers(**numbers).slope)
        + 0.5 * momentum
        - 0.1 * speed2
        - 0.1 * effort
        - POWER_CHARGE * power
    )


# ---- What is observed ----------------------------------------------------------------------------


def observation(state: State, slope: float = Numbers.slope) -> list[float]:
    """76 numbers: 19 x from node 0, 19 y from the slope's height at node 0, 19 vx, 19 vy."""
    x0 = state[0][0]
    return [
        *(x - x0 for x, _, _, _ in state),
        *(y - math.tan(slope) * x0 for _, y, _, _ in state),
        *(vx for _, _, vx, _ in state),
        *(vy for _, _, _, vy in state),
    ]


# ---- The networks --------------------------------------------------------------------------------


def elu(x: float) -> float:
    return x if x > 0 else math.expm1(x)


def network(layers: list[Layer], inputs: list[float]) -> list[float]:
    """Each layer gives row . inputs + bias for each row; ELU between layers, the last linear."""
    values = inputs
    for k, (rows, biases) in enumerate(layers):
        if k > 0:
            values = [elu(v) for v in values]
        values = [
            sum(w * v for w, v in zip(row, values, strict=True)) + bias
            for row, bias in zip(rows, biases, strict=True)
        ]
    return values


# ---- The audience --------------------------------------------------------------------------------


def log_likelihood(
    observed_next: State, predicted_next: State, sigma: float = 1.0, slope: float = Numbers.slope
) -> float:
    """-mean((obs' - pred)^2) / (2 sigma^2) over the 76 numbers of two states."""
    seen, expected = observation(observed_next, slope), observation(predicted_next, slope)
    squares = [(a - b) ** 2 for a, b in zip(seen, expected, strict=True)]
    return -sum(squares) / len(squares) / (2 * sigma**2)


def update(
    belief: list[float], log_likelihoods: list[float], forgetting: float = FORGETTING
) -> list[float]:
    """Bayes, normalise, forget: p <- p (1 - eps) + (1 - p) / (N - 1) eps."""
    top = max(log_likelihoods[i] for i, p in enumerate(belief) if p > 0)
    joint = [
        p * math.exp(x - top) if p > 0 else 0.0
        for p, x in zip(belief, log_likelihoods, strict=True)
    ]
    posterior = [p / sum(joint) for p in joint]
    others = len(belief) - 1
    return [p * (1 - forgetting) + (1 - p) / others * forgetting for p in posterior]
