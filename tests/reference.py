"""The equations of the kitchen and of the language, with dictionaries and loops.

An independent transcription of design/model.md ("Kitchen") and design/language.md, of
docs/worlds.md ("Three and more"), and of the paper ("Acting as Inverse Inverse Planning", sections
"Inverse planning", "Inverse inverse planning", "Implementation details"). It imports nothing of the
package, and the package is tested against it on small maps. Clarity goes before speed (only the
sweeps of value iteration are products of matrices), so the order here is that of the texts: map and
moves, rewards, planning, hypotheses, the audience's filter, scripts, queries, predicates, stories,
search.

A state is a tuple of cells (column, row), or None where absent, in the order of `world.entities`
(characters in acting order, then objects); wherever a state is asked for, the mapping of
script.json ({"cheese": [3, 1], ..., "table": null}) will do as well. A hypothesis is a dict such as
{"G_cheese": "pink", "G_robot": "none", "rho": 3, "R_cheese": True, "R_robot": True}, without the
latents that play no part. An event is a function hypothesis -> bool.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations, permutations, product

import numpy as np

MOVES = {"north": (0, -1), "south": (0, 1), "east": (1, 0), "west": (-1, 0)}
ACTIONS = (*MOVES, "stay")
TOLERANCE = 1e-10  # a proven bound on the error of every planned value


@dataclass(frozen=True)
class Character:
    """One with `toward` is paid rho times the other's reward, and plans against its policy; one
    with several says {other: values of rho}."""

    name: str
    success: float = 1.0
    pushes: tuple = ()
    goals: tuple = ("none",)
    toward: str | dict | None = None
    attitude: tuple = ()  # the values of rho, where `toward` is a name
    models: str | tuple = ()  # without attitude: plans against the other's policy nevertheless
    misreads: tuple = ()  # those of whom it may be wrong about what they want

    @property
    def attitudes(self):
        """{other: the values of rho toward it}"""
        if isinstance(self.toward, dict):
            return self.toward
        return {self.toward: self.attitude} if self.toward else {}

    @property
    def modelled(self):
        models = (self.models,) if isinstance(self.models, str) else self.models
        return {*self.attitudes, *models}


@dataclass(frozen=True)
class Object:
    name: str
    may_be_absent: bool = False


def rational(h):
    """The default assumption: every character is rational."""
    return all(value for latent, value in h.items() if latent.startswith("R_"))


class World:
    """A grid world, its characters' plans, and the audience that interprets them."""

    def __init__(
        self,
        rows,
        tiles,
        characters,
        objects=(),
        rewards=None,
        gamma=0.99,
        beta=2.0,
        forgetting=1e-5,
        level0="uniform",
        hypotheses="merged",
    ):
        self.free = {
            (x, y) for y, row in enumerate(rows) for x, mark in enumerate(row) if mark != "#"
        }
        self.tiles = {name: tuple(cell) for name, cell in tiles.items()}
        self.characters = {c.name: c for c in characters}  # in acting order
        self.objects = {o.name: o for o in objects}
        self.entities = (*self.characters, *self.objects)
        self.rewards = {"goal": 1.0, "move": -1.0, "stay": -0.1, **(rewards or {})}
        self.gamma, self.beta, self.forgetting, self.level0 = gamma, beta, forgetting, level0
        self.position = {name: i for i, name in enumerate(self.entities)}
        assert len(self.characters) in (1, 2, 3, 4)
        assert level0 in ("uniform", "costs")
        assert hypotheses in ("merged", "literal")
        pairs = [(c.name, other) for c in characters for other in c.attitudes]
        self.rho = {pair: "rho" if len(pairs) == 1 else "_".join(("rho", *pair)) for pair in pairs}
        self.hypotheses = merged(self) if hypotheses == "merged" else literal(self)
        self._values, self._q, self._replies, self._filtered = {}, {}, {}, {}  # memory only
        self._policies = {}  # so, too

    # ---- States and moves ---------------------------------------------------------------------

    def state(self, cells):
        """The tuple of a mapping of script.json; checks that no two are on one cell."""
        if not isinstance(cells, tuple):
            cells = tuple(tuple(cells[n]) if cells[n] else None for n in self.entities)
        there = [cell for cell in cells if cell]
        assert len(set(there)) == len(there), f"two on one cell: {cells}"
        assert set(there) <= self.free, f"not on the floor: {cells}"
        return cells

    def cell(self, state, name):
        return self.state(state)[self.position[name]]

    def mapping(self, state):
        return {n: list(c) if c else None for n, c in zip(self.entities, state, strict=True)}

    def placed(self, state, name, cell):
        i = self.position[name]
        return (*state[:i], cell, *state[i + 1 :])

    def states(self, present):
        """All states in which exactly the entities `present` are there: no two on one cell."""
        for cells in permutations(sorted(self.free), len(present)):
            at = dict(zip(present, cells, strict=True))
            yield tuple(at.get(name) for name in self.entities)

    def presences(self):
        """The sets of entities that may be there together, each in the order of `entities`."""
        missing = [o.name for o in self.objects.values() if o.may_be_absent]
        for k in range(len(missing) + 1):
            for absent in combinations(missing, k):
                yield tuple(n for n in self.entities if n not in absent)

    def count_states(self):
        """sum over the presences of n (n - 1) ... (n - m + 1), m things on n free cells."""
        return sum(math.perm(len(self.free), len(present)) for present in self.presences())

    def others(self, who):
        """Who acts between two of its actions, in that order."""
        names = list(self.characters)
        i = names.index(who)
        return names[i + 1 :] + names[:i]

    def effect(self, state, who, action):
        """The state after `action` if it succeeds; the same state if it is blocked (or 'stay').

        A move leads to the neighbouring cell if that is free; if something stands there that `who`
        pushes, that is pushed one cell in the same direction if that cell is free and inside.
        """
        if action == "stay":
            return state
        (x, y), (dx, dy) = state[self.position[who]], MOVES[action]
        to, beyond = (x + dx, y + dy), (x + 2 * dx, y + 2 * dy)
        if to not in self.free:
            return state
        if to in state:
            thing = self.entities[state.index(to)]
            if thing not in self.characters[who].pushes:
                return state
            if beyond not in self.free or beyond in state:  # cannot push two things at once
                return state
            state = self.placed(state, thing, beyond)
        return self.placed(state, who, to)

    def outcomes(self, state, who, action):
        """[(probability, state)]: a move succeeds with probability `success`, else nothing happens.

        A blocked move, a stay and a move that cannot fail have one outcome.
        """
        success, after = self.characters[who].success, self.effect(state, who, action)
        if after == state or success == 1:
            return [(1.0, after)]
        return [(success, after), (1 - success, state)] if success > 0 else [(1.0, state)]

    # ---- Planning -----------------------------------------------------------------------------

    def cost(self, action):
        return self.rewards["stay" if action == "stay" else "move"]

    def reward(self, who, goal, state, action):
        """r(s, a): 1.0 on its own goal tile, plus -1.0 for a move or -0.1 for staying."""
        here = state[self.position[who]]
        return self.cost(action) + (self.rewards["goal"] if here == self.tiles.get(goal) else 0.0)

    def pi_0(self):
        """Level 0: uniform over the actions, or softmax(beta times the cost of the action)."""
        if self.level0 == "costs":
            return softmax({b: self.beta * self.cost(b) for b in ACTIONS})
        return dict.fromkeys(ACTIONS, 1 / len(ACTIONS))

    def view(self, who, other, h):
        """How `who` sees another: 'level 0', 'random', or as the one whose problem that is."""
        if other not in self.characters[who].modelled:
            return "level 0"
        if not h[f"R_{other}"]:
            return "random"
        taken = h.get(f"B_{who}_{other}", h[f"G_{other}"])  # what it is taken to want
        return self.problem(other, h | {f"G_{other}": taken})

    def problem(self, who, h):
        """What a plan depends on: (who, own goal, [(other, rho toward it, view of it)])."""
        rhos = {o: h[self.rho[who, o]] for o in self.characters[who].attitudes}
        others = [(o, rhos.get(o, 0), self.view(who, o, h)) for o in self.others(who)]
        return who, h[f"G_{who}"], tuple(others)

    def reply(self, other, view, state):
        """One other's action, as it is seen: (what it gets for it, {s'': probability})."""
        key = (other, view, state)
        if key not in self._replies:
            if view == "level 0":
                policy = self.pi_0()
            elif view == "random":
                policy = dict.fromkeys(ACTIONS, 1 / len(ACTIONS))
            else:
                policy = softmax({a: self.beta * q for a, q in self._backup(view, state).items()})
            paid, reached = 0.0, {}
            for action, p in policy.items():
                if isinstance(view, tuple):  # only the rational are cared about
                    paid += p * self.reward(other, view[1], state, action)
                for chance, result in self.outcomes(state, other, action):
                    reached[result] = reached.get(result, 0.0) + p * chance
            self._replies[key] = paid, reached
        return self._replies[key]

    def answer(self, problem, state):
        """The others' actions in s', one after the other: (sum_j rho_j E[r_j], {s'': probability}).

        For one other (rho sum_b pi(b | s') r_j(s', b), {s'': sum_b pi(b | s') P(s'' | s', b)}).
        """
        social, reached = 0.0, {state: 1.0}
        for other, rho, view in problem[2]:
            before, reached = reached, {}
            for s, p in before.items():
                paid, after = self.reply(other, view, s)
                social += rho * p * paid
                for result, q in after.items():
                    reached[result] = reached.get(result, 0.0) + p * q
        return social, reached

    def _plan(self, problem, present):
        """V in all states with `present`: the fixed point, to a proven 1e-10.

        With i = whose problem it is, j, k, ... = the others in the order in which they act, s the
        state in which i is to act,

            Q_i(s, a)  = r_i(s, a) + gamma sum_s' P_i(s' | s, a) E_j[E_k[...[V_i]]](s')
            E_j[W](s') = sum_b pi_j(b | s') (rho_j r_j(s', b) + sum_s'' P_j(s'' | s', b) W(s''))
            V_i(s)     = max_a Q_i(s, a)

        where pi_j is pi_0 and rho_j = 0 where i does not model j (the cheese the robot), j's own
        softmax policy where it does (the robot the cheese), uniform where j is irrational.
        Value iteration by full sweeps T, with the bounds of MacQueen and Porteus: with m, M the
        least and greatest change of a sweep, V* lies between TV + c m and TV + c M,
        c = gamma / (1 - gamma). Each sweep goes on from the middle of the two.
        """
        states = list(self.states(present))
        number = {s: i for i, s in enumerate(states)}
        who, goal, _ = problem
        own = np.zeros((2, len(states), len(ACTIONS)))  # r_i, and how likely the action is to work
        leads = np.zeros((2, len(states), len(ACTIONS)), int)  # where it does, and does not
        social, answer = np.zeros(len(states)), np.zeros((len(states), len(states)))
        for i, s in enumerate(states):
            for k, a in enumerate(ACTIONS):
                (p, t), (_, u) = [*self.outcomes(s, who, a), (0.0, s)][:2]
                own[:, i, k] = self.reward(who, goal, s, a), p
                leads[:, i, k] = number[t], number[u]
            social[i], after = self.answer(problem, s)
            for t, p in after.items():
                answer[i, number[t]] += p
        (reward, works), (t, u) = own, leads
        gamma, c = self.gamma, self.gamma / (1 - self.gamma)
        values = np.zeros(len(states))
        while True:
            w = social + answer @ values
            new = (reward + gamma * (works * w[t] + (1 - works) * w[u])).max(1)
            low, high = (new - values).min(), (new - values).max()
            values = new + c * (low + high) / 2
            if c * (high - low) / 2 <= TOLERANCE:
                return dict(zip(states, values.tolist(), strict=True))

    def _planned(self, problem, state):
        """The values of all states with the same things present (no plan foresees a fall)."""
        present = tuple(n for n in self.entities if state[self.position[n]])
        key = (problem, present)
        if key not in self._values:
            self._values[key] = self._plan(problem, present)
        return self._values[key]

    def _backup(self, problem, state):
        """{action: Q(s, action)}, by one backup from the values."""
        key = (problem, state)
        if key not in self._q:
            (who, goal, _), values, q = problem, self._planned(problem, state), {}
            for a in ACTIONS:
                q[a] = self.reward(who, goal, state, a)
                for p, s1 in self.outcomes(state, who, a):
                    social, after = self.answer(problem, s1)
                    w = social + sum(chance * values[s2] for s2, chance in after.items())
                    q[a] += self.gamma * p * w
            self._q[key] = q
        return self._q[key]

    def value(self, who, h, state):
        """V_who(s) under a hypothesis in which `who` is rational."""
        state = self.state(state)
        return self._planned(self.problem(who, h), state)[state]

    def q_values(self, who, h, state):
        """{action: Q_who(s, action)} under a hypothesis in which `who` is rational."""
        return self._backup(self.problem(who, h), self.state(state))

    def log_policy(self, who, h, state):
        """log P(a | s, H) = log softmax(beta Q_H(s, .))[a]; uniform for an irrational character."""
        if not h[f"R_{who}"]:
            return dict.fromkeys(ACTIONS, -math.log(len(ACTIONS)))
        key = (who, tuple(h.items()), state if isinstance(state, tuple) else self.state(state))
        if key not in self._policies:
            q = self.q_values(who, h, state)
            self._policies[key] = log_softmax({a: self.beta * value for a, value in q.items()})
        return self._policies[key]

    def policy(self, who, h, state):
        return {a: math.exp(log_p) for a, log_p in self.log_policy(who, h, state).items()}

    def log_likelihood(self, who, h, state, action):
        return self.log_policy(who, h, state)[action]

    # ---- The audience -------------------------------------------------------------------------

    def prior(self):
        return dict.fromkeys(range(len(self.hypotheses)), 1 / len(self.hypotheses))

    def update(self, belief, who, state, action):
        """One observed action: Bayes P(H | s -> a) ~ P(s -> a | H) P(H), normalise, forget."""
        logs = {
            i: self.log_likelihood(who, h, state, action) for i, h in enumerate(self.hypotheses)
        }
        top = max(logs.values())
        return self.forget(normalised({i: p * math.exp(logs[i] - top) for i, p in belief.items()}))

    def forget(self, belief):
        """p <- p (1 - eps) + (1 - p) / (N - 1) eps."""
        n, eps = len(belief), self.forgetting
        return {i: p * (1 - eps) + (1 - p) / (n - 1) * eps for i, p in belief.items()}

    def actions(self, state, frame):
        """[(who, action, state acted from, state after)] of a frame; [] of an event."""
        done = []
        for who in self.characters if not frame.get("event") else ():
            action, moved = frame[who]["action"], frame[who]["moved"]
            after = self.effect(state, who, action) if moved else state
            assert after in [s for _, s in self.outcomes(state, who, action)], frame
            assert moved == (after != state), frame
            done.append((who, action, state, after))
            state = after
        return done

    def after(self, state, frame):
        """The state that a frame leads to, checked against the state it says."""
        if frame.get("event"):
            thing, to = frame["event"]["deus"], tuple(frame["event"]["to"])
            assert state[self.position[thing]] is None, "only while it is absent"
            state = self.state(self.placed(state, thing, to))  # only onto a free, unoccupied cell
        for *_, after in self.actions(state, frame):
            state = after
        assert state == self.state(frame["state"]), frame
        return state

    def filtered(self, script):
        """[(state, belief, before)] of frames 0..T; before: the beliefs before each of its actions.

        Two updates a turn, one after each character's action; an event updates nothing.
        """
        state = self.state(script["start"])
        steps, key = [(state, self.prior(), [])], (state,)
        for frame in script["frames"]:
            key = (key, frame_key(self, frame))
            if key not in self._filtered:
                (state, belief, _), before = steps[-1], []
                for who, action, acted_from, _ in self.actions(state, frame):
                    before.append(belief)
                    belief = self.update(belief, who, acted_from, action)
                self._filtered[key] = (self.after(state, frame), belief, before)
            steps.append(self._filtered[key])
        return steps

    def beliefs(self, script):
        """[{hypothesis index: P(H | script[:t])}] for t = 0..T."""
        return [belief for _, belief, _ in self.filtered(script)]

    def beliefs_before(self, script, k):
        """[(who, action, state acted from, belief just before)] of the actions seen in frame k."""
        steps = self.filtered(script)
        seen = self.actions(steps[k - 1][0], script["frames"][k - 1])
        return [(*a[:3], b) for a, b in zip(seen, steps[k][2], strict=True)]

    def state_at(self, script, k):
        """The state at the end of frame k (0: the start)."""
        return self.filtered(script)[k][0]


# ---- Hypotheses ----------------------------------------------------------------------------------


def literal(world):
    """All combinations of the paper's tuple (G and R of each character, each rho; and B, what one
    takes another to want, where one may be wrong about it), taken literally.

    "When the cheese is irrational, we only include hypotheses where the robot is indifferent":
    rho = 0 alone, where the one it is about is irrational. Kitchen: G_cheese (2) x G_robot (3) x
    rho (5) x R_robot (2) = 60 with R_cheese, and 2 x 3 x 1 x 2 = 12 without: 72. An irrational
    robot beside a cheese of given goal counts 3 x 5 = 15 times, both irrational 2 x 3 times, and
    rho = 0 with no goal is in. The repetitions stay (they are what weighs); the latents that play
    no part, goal and rho of the irrational, are dropped, so that comparisons on them are false.
    """
    names = list(world.characters)
    reads = [(who, other) for who in names for other in world.characters[who].misreads]
    taken = list(product(*(world.characters[other].goals for _, other in reads)))
    goals = product(*(c.goals for c in world.characters.values()))
    goals = [dict(zip(names, each, strict=True)) for each in goals]
    found = []
    for flags in product((True, False), repeat=len(names)):
        r = dict(zip(names, flags, strict=True))
        values = [
            world.characters[who].attitudes[other] if r[other] else (0,) for who, other in world.rho
        ]
        for goal, rhos, seen in product(goals, product(*values), taken):
            h = {f"G_{n}": goal[n] for n in names if r[n]}
            attitudes = zip(world.rho.items(), rhos, strict=True)
            h |= {latent: rho for ((who, _), latent), rho in attitudes if r[who]}
            readings = zip(reads, seen, strict=True)
            h |= {f"B_{who}_{other}": g for (who, other), g in readings if r[who] and r[other]}
            found.append(h | {f"R_{n}": r[n] for n in names})
    return found


def merged(world):
    """Each of those once, less those by which a rational one could care about somebody rational,
    cares about nobody, and wants no tile.

    Kitchen: both rational 2 x 3 x 5 - 2 = 28; cheese irrational, rho = 0: 3 goals of the robot;
    robot irrational: 2 goals of the cheese; both irrational: 1. Together 34.
    """
    found = []
    for h in literal(world):
        if h not in found and not any(idles(world, h, who) for who in world.characters):
            found.append(h)
    return found


def idles(world, h, who):
    """A rational one could care about somebody rational, cares about nobody, wants no tile."""
    about = [other for other in world.characters[who].attitudes if h[f"R_{other}"]]
    if not (h[f"R_{who}"] and about and h[f"G_{who}"] == "none"):
        return False
    return all(h[world.rho[who, other]] == 0 for other in about)


# ---- Small arithmetic ----------------------------------------------------------------------------


def log_softmax(x):
    top = max(x.values())
    total = top + math.log(sum(math.exp(v - top) for v in x.values()))
    return {k: v - total for k, v in x.items()}


def softmax(x):
    return {k: math.exp(v) for k, v in log_softmax(x).items()}


def normalised(weights):
    total = sum(weights.values())
    return {k: w / total for k, w in weights.items()}


# ---- Scripts -------------------------------------------------------------------------------------


def frame_key(world, frame):
    if frame.get("event"):
        return frame["event"]["deus"], tuple(frame["event"]["to"])
    return tuple((frame[who]["action"], frame[who]["moved"]) for who in world.characters)


def turn(world, state, actions):
    """The frame of {"cheese": "west!", "robot": "east"}: succeeds if it can, `west!` fails."""
    frame, state = {"event": None}, world.state(state)
    for who in world.characters:
        action = actions[who].removesuffix("!")
        after = state if actions[who].endswith("!") else world.effect(state, who, action)
        frame[who] = {"action": action, "moved": after != state}
        state = after
    return {**frame, "state": world.mapping(state)}


def deus(world, state, thing, cell):
    """The frame of an event: `thing` falls onto `cell`; nobody acts."""
    state = world.placed(world.state(state), thing, tuple(cell))
    return {"event": {"deus": thing, "to": list(cell)}, "state": world.mapping(state)}


def new_script(world, start):
    return {"start": world.mapping(world.state(start)), "frames": []}


def append(script, frame):
    """script ++ [frame]"""
    return {**script, "frames": [*script["frames"], frame]}


def prefix(script, n):
    return {**script, "frames": script["frames"][:n]}


# ---- Queries: of (world, script, k), given `conditions` and `assume` (None: nothing) -------------

Event = Callable[[dict], bool]


def given(world, belief, conditions: Iterable[Event] = (), assume: Event | None = rational):
    """P(H | ..., conditions, assumption), from the belief over all hypotheses: mask, normalise."""
    masks = [*conditions, *([assume] if assume else [])]
    kept = {i: p for i, p in belief.items() if all(m(world.hypotheses[i]) for m in masks)}
    assert kept, "no hypothesis fulfils the conditions"
    return normalised(kept)


def posterior(world, script, k, conditions=(), assume=rational):
    return given(world, world.beliefs(script)[k], conditions, assume)


def P(world, script, k, event, conditions=(), assume=rational):
    """P(event | script[:k], conditions)"""
    belief = posterior(world, script, k, conditions, assume)
    return sum(p for i, p in belief.items() if event(world.hypotheses[i]))


def E(world, script, k, quantity, conditions=(), assume=rational):
    """E[quantity(H) | script[:k], conditions], given that the quantity is defined (not None)."""
    defined = [*conditions, lambda h: quantity(h) is not None]
    belief = posterior(world, script, k, defined, assume)
    return sum(p * quantity(world.hypotheses[i]) for i, p in belief.items())


def EV(world, script, k, who, conditions=(), assume=rational):
    """E[V(who) | script[:k], conditions]: V at the end of frame k, given that `who` is rational."""
    state, conditions = world.state_at(script, k), [*conditions, lambda h: h[f"R_{who}"]]
    return E(world, script, k, lambda h: world.value(who, h, state), conditions, assume)


def marginal(world, belief, latent=None):
    """{value: probability} of a latent, 'unknown' where it plays no part; None: of the whole H."""
    if latent is None:
        return belief
    result = {}
    for i, p in belief.items():
        value = world.hypotheses[i].get(latent, "unknown")
        result[value] = result.get(value, 0.0) + p
    return result


def joint(world, belief, latents):
    """{values: probability} of several latents together, each 'unknown' where it plays no part."""
    result = {}
    for i, p in belief.items():
        values = tuple(world.hypotheses[i].get(latent, "unknown") for latent in latents)
        result[values] = result.get(values, 0.0) + p
    return result


def posterior_within(world, script, k, seen, assume=rational):
    """The belief once `seen` actions of frame k were observed; at its end where there are fewer."""
    before = [belief for *_, belief in world.beliefs_before(script, k)]
    belief = before[seen] if seen < len(before) else world.beliefs(script)[k]
    return given(world, belief, (), assume)


def next_action(world, script, k, who, assume=rational):
    """{action: probability} of what `who` does in frame k + 1, over all frames that may follow."""
    shown, state, result = prefix(script, k), world.state_at(script, k), {}
    for frame in children(world, state):
        longer = append(shown, frame)
        p = math.exp(-surprise(world, longer, k + 1, assume)) * chance(world, state, frame)
        action = frame[who]["action"]
        result[action] = result.get(action, 0.0) + p
    return result


def KL(world, script, a, b, latent=None, assume=rational):
    """KL(script[:a] || script[:b]) = sum p_a log(p_a / p_b), of one latent's marginal or of H."""
    p, q = (marginal(world, posterior(world, script, k, (), assume), latent) for k in (a, b))
    return sum(p[v] * math.log(p[v] / q[v]) for v in p if p[v] > 0)


def entropy(world, script, k, latent=None, conditions=(), assume=rational):
    """entropy(latent | script[:k]) = -sum p log p, in nats; without a latent, of the hypothesis."""
    p = marginal(world, posterior(world, script, k, conditions, assume), latent)
    return -sum(x * math.log(x) for x in p.values() if x > 0)


def log_predictive(world, belief, who, state, action, assume=rational):
    """log sum_H P(H | belief, assumption) P(a | s, H)"""
    logs = {
        i: math.log(p) + world.log_likelihood(who, world.hypotheses[i], state, action)
        for i, p in given(world, belief, (), assume).items()
        if p > 0
    }
    top = max(logs.values())
    return top + math.log(sum(math.exp(x - top) for x in logs.values()))


def surprise(world, script, k, assume=rational):
    """-log of the product of the predictive probabilities of the actions observed in frame k.

    Each under the belief just before it; chance outcomes and events contribute nothing.
    """
    return -sum(
        log_predictive(world, belief, who, state, action, assume)
        for who, action, state, belief in world.beliefs_before(script, k)
    )


def chance(world, state, frame):
    """The probability of the frame's chance outcomes, given its actions."""
    p = 1.0
    for who, action, acted_from, after in world.actions(world.state(state), frame):
        p *= sum(q for q, s in world.outcomes(acted_from, who, action) if s == after)
    return p


def suspense(world, script, k, latent=None, assume=rational):
    """sum_v Var[P(latent = v | script[:k + 1])] over the next frame as the audience predicts it.

    A frame's probability is that of its actions, exp(-surprise), times that of its chance outcomes.
    """
    shown, state, frames = prefix(script, k), world.state_at(script, k), []
    for frame in children(world, state):
        longer = append(shown, frame)
        p = math.exp(-surprise(world, longer, k + 1, assume)) * chance(world, state, frame)
        frames.append((p, marginal(world, posterior(world, longer, k + 1, (), assume), latent)))
    assert math.isclose(sum(p for p, _ in frames), 1, abs_tol=1e-9)
    total = 0.0
    for v in frames[0][1]:
        mean = sum(p * belief[v] for p, belief in frames)
        total += sum(p * (belief[v] - mean) ** 2 for p, belief in frames)
    return total


# ---- Predicates: of a state; of frame k of a script ----------------------------------------------


def at(world, state, who, place):
    here = world.cell(state, who)
    return here is not None and here == (world.tiles[place] if isinstance(place, str) else place)


def absent(world, state, thing):
    return world.cell(state, thing) is None


def adjacent(world, state, a, b):
    p, q = world.cell(state, a), world.cell(state, b)
    return bool(p and q) and abs(p[0] - q[0]) + abs(p[1] - q[1]) == 1


def _own(world, script, k, who):
    """(action, state before, state after) of who's own action in frame k; None in an event."""
    for name, *rest in world.actions(world.state_at(script, k - 1), script["frames"][k - 1]):
        if name == who:
            return rest
    return None


def pushes(world, script, k, a, b):
    """a's action in frame k moved b."""
    own = _own(world, script, k, a)
    return own is not None and world.cell(own[1], b) != world.cell(own[2], b)


def moved(world, script, k, who):
    """who's own action in frame k changed its cell (being pushed does not count)."""
    return pushes(world, script, k, who, who)


def tried(world, script, k, who):
    """who chose a move in frame k."""
    own = _own(world, script, k, who)
    return own is not None and own[0] != "stay"


def idle(world, script, k, who):
    return not tried(world, script, k, who)


DIRECTIONS = {"north": (0, -1), "south": (0, 1), "east": (1, 0), "west": (-1, 0)}


def faces(world, script, k, who, spot):
    """who chose to move in frame k, along the axis on which it is farther to the spot."""
    own = _own(world, script, k, who)
    if own is None or own[0] == "stay":
        return False
    (x, y), there = world.cell(own[1], who), _spot(world, own[1], spot)
    if there is None:
        return False
    dx, dy = there[0] - x, there[1] - y
    choices = {"east": dx, "west": -dx, "south": dy, "north": -dy}
    return choices[own[0]] > 0 and choices[own[0]] == max(choices.values())


def _spot(world, state, spot):
    """The cell of a character, a thing or a tile."""
    return world.tiles[spot] if spot in world.tiles else world.cell(state, spot)


def sees(world, state, who, spot):
    """No wall's open square is on the line between the middles: each cut by its four edges."""
    here, there = world.cell(state, who), _spot(world, state, spot)
    if not here or not there:
        return False
    columns, rows = (range(max(c[i] for c in world.free) + 1) for i in (0, 1))
    for wall in {(x, y) for x in columns for y in rows} - world.free:
        first, last = Fraction(0), Fraction(1)
        for a, b, middle in zip(here, there, wall, strict=True):
            low, high = middle - Fraction(1, 2), middle + Fraction(1, 2)
            if a == b:
                first, last = (first, last) if low < a < high else (1, 0)
                continue
            ends = sorted(((low - a) / (b - a), (high - a) / (b - a)))
            first, last = max(first, ends[0]), min(last, ends[1])
        if first < last:
            return False
    return True


def distance(world, state, who, spot):
    """The fewest steps among walls, breadth first; as many as cells where no way leads."""
    here, there = world.cell(state, who), _spot(world, state, spot)
    found, steps = {here} - {None}, 0
    while found and there is not None:
        if there in found:
            return steps
        near = {(x + dx, y + dy) for x, y in found for dx, dy in DIRECTIONS.values()}
        if not (near & world.free) - found:
            break
        found, steps = found | (near & world.free), steps + 1
    return len(world.free)


def fell(world, script, k, thing):
    """An event dropped it in frame k."""
    event = script["frames"][k - 1].get("event")
    return bool(event) and event["deus"] == thing


# ---- The paper's stories: of (world, prefix of n frames, T) --------------------------------------


def rho_is(sign):
    """rho > 0, rho < 0, rho = 0: false where rho plays no part."""
    return lambda h: "rho" in h and (h["rho"] > 0) - (h["rho"] < 0) == sign


def latent_is(latent, value):
    return lambda h: h.get(latent) == value


HELPS, HINDERS, INDIFFERENT = rho_is(1), rho_is(-1), rho_is(0)


def frames_of(script):
    return range(1, len(script["frames"]) + 1)


def depict(world, script, event):
    """sum_{t in 1..last(over)} P(event | over[:t])"""
    return sum(P(world, script, t, event) for t in frames_of(script))


def moved_others(world, script, turn, about):
    """sum of KL(others; script[:t-1] || script[:t]) over the frames t within one of turn + 1, where
    `others` are all latents but those in `about`, together."""

    def others(k):
        shares = {}
        for i, p in posterior(world, script, k, (), rational).items():
            rest = tuple(sorted((n, v) for n, v in world.hypotheses[i].items() if n not in about))
            shares[rest] = shares.get(rest, 0) + p
        return shares

    total = 0.0
    for t in frames_of(script):
        if abs(t - turn - 1) <= 1:
            p, q = others(t - 1), others(t)
            total += sum(p[v] * math.log(p[v] / q[v]) for v in p if p[v] > 0)
    return total


def twist(world, script, T, before, after, wish):
    """sum_t (if t <= T/2 then P(before | script[:t], wish) else P(after | script[:t], wish)), one
    point for each half in which the two meet, less what moves beliefs about anything but rho around
    the turn."""
    first = [t for t in frames_of(script) if t <= T / 2]
    second = [t for t in frames_of(script) if t > T / 2]
    asked = sum(P(world, script, t, before, [wish]) for t in first)
    asked += sum(P(world, script, t, after, [wish]) for t in second)
    meet = lambda t: adjacent(world, world.state_at(script, t), "robot", "cheese")
    asked += any(map(meet, first)) + any(map(meet, second))
    return asked - 0.5 * moved_others(world, script, T / 2, {"rho"})


def irony(world, script, truth, mistaken, meant, done):
    """sum_t (P(truth | s[:t]) + P(done | s[:t], truth) + P(meant | s[:t], mistaken))"""
    return sum(
        P(world, script, t, truth)
        + P(world, script, t, done, [truth])
        + P(world, script, t, meant, [mistaken])
        for t in frames_of(script)
    )


def flashback(world, script, event):
    """depict(event, over = shown) + [pushes(robot, cheese) @ shown[T+1]].

    let shown = script ++ [cheese: stay, robot: east]: frame T+1, from where the prefix ends.
    """
    n = len(script["frames"])
    last = turn(world, world.state_at(script, n), {"cheese": "stay", "robot": "east"})
    shown = append(script, last)
    return depict(world, shown, event) + pushes(world, shown, n + 1, "robot", "cheese")


def arc(world, script, T, who="robot", scale=0.02, steady=0.1):
    """sum_t (scale sin(t/T 3 pi) E[V(who) | s[:t]] - steady KL(s[:t-1] || s[:t]))"""
    return sum(
        scale * math.sin(t / T * 3 * math.pi) * EV(world, script, t, who)
        - steady * KL(world, script, t - 1, t)
        for t in frames_of(script)
    )


GREEN, PINK = latent_is("G_cheese", "green"), latent_is("G_cheese", "pink")
STORIES = {
    "help": lambda w, s, T: depict(w, s, HELPS),
    "hinder": lambda w, s, T: depict(w, s, HINDERS),
    "indifferent": lambda w, s, T: depict(w, s, INDIFFERENT),
    "betrayal": lambda w, s, T: twist(w, s, T, HELPS, HINDERS, PINK),
    "misjudged": lambda w, s, T: twist(w, s, T, HINDERS, HELPS, PINK),
    "irony": lambda w, s, T: irony(w, s, GREEN, PINK, HELPS, HINDERS),
    "flashback-help": lambda w, s, T: flashback(w, s, HELPS),
    "flashback-hinder": lambda w, s, T: flashback(w, s, HINDERS),
    "arc": lambda w, s, T: arc(w, s, T, scale=0.1),
}


def rationality(world, script):
    """sum_t P(R_cheese and R_robot | script[:t]), not conditioned on the assumption."""
    return sum(P(world, script, t, rational, assume=None) for t in frames_of(script))


def plausibility(world, script):
    """-(p_hat - p)^2 of each weak character; p_hat: the share of its attempts that succeeded.

    A move into an obstacle is no attempt; with no attempt the term is 0.
    """
    total = 0.0
    for who in [c.name for c in world.characters.values() if c.success < 1]:
        attempts = []
        for t in frames_of(script):
            own = _own(world, script, t, who)
            if own and world.effect(own[1], who, own[0]) != own[1]:
                attempts.append(own[2] != own[1])
        if attempts:
            total -= (sum(attempts) / len(attempts) - world.characters[who].success) ** 2
    return total


def naturalness(world, script):
    """- sum over all observed actions of E[max_a log P(a | H) - log P(action | H)], under the
    belief just after the action, everybody being rational."""
    steps, total = world.filtered(script), 0.0
    for t in frames_of(script):
        seen = world.actions(steps[t - 1][0], script["frames"][t - 1])
        _, last, before = steps[t]
        for (who, action, state, _), belief in zip(seen, [*before[1:], last], strict=False):
            for i, p in given(world, belief).items():
                log_policy = world.log_policy(who, world.hypotheses[i], state)
                total -= p * (max(log_policy.values()) - log_policy[action])
    return total


def luck(world, script):
    """- max(0, C - log 4) of each weak character: C is the largest sum, over any stretch of its
    attempts, of log P(outcome | odds 6 times better, or worse) - log P(outcome)."""
    total = 0.0
    for who in [c.name for c in world.characters.values() if c.success < 1]:
        p = world.characters[who].success
        outcomes = []
        for t in frames_of(script):
            own = _own(world, script, t, who)
            if own and world.effect(own[1], who, own[0]) != own[1]:
                outcomes.append(own[2] != own[1])
        most = 0.0
        for factor in (6, 1 / 6):
            odds = factor * p / (1 - p)
            other = odds / (1 + odds)
            ratios = [
                math.log(other / p) if ok else math.log((1 - other) / (1 - p)) for ok in outcomes
            ]
            stretches = [
                sum(ratios[i:j]) for i in range(len(ratios)) for j in range(i + 1, len(ratios) + 1)
            ]
            most = max([most, *stretches])
        total -= max(0.0, most - math.log(4))
    return total


def liveliness(world, script):
    """- the number of frames at whose end everything is where it was."""
    return -sum(
        world.state_at(script, t - 1) == world.state_at(script, t) for t in frames_of(script)
    )


AUTOMATIC = {
    "rationality": (1.0, rationality),
    "plausibility": (1.0, plausibility),
    "naturalness": (0.2, naturalness),
    "luck": (0.5, luck),
    "liveliness": (0.2, liveliness),
}
"""The automatic terms with their weights."""


def objective(story, T, **weights):
    """The objective of a prefix, with the automatic terms: (world, script) -> number."""
    story = STORIES.get(story, story)
    return lambda world, script: (
        story(world, script, T)
        + sum(
            weights.get(name, weight) * term(world, script)
            for name, (weight, term) in AUTOMATIC.items()
        )
    )


# ---- Search --------------------------------------------------------------------------------------


def children(world, state, allow=()):
    """Every next frame: all joint turns, and the allowed things falling onto any free cell.

    A stay or a blocked move has one outcome; a move that may fail has two.
    """
    state = world.state(state)
    turns = [({"event": None}, state)]
    for who in world.characters:
        longer = []
        for (frame, s), action in product(turns, ACTIONS):
            for _, after in world.outcomes(s, who, action):
                done = {"action": action, "moved": after != s}
                longer.append(({**frame, who: done}, after))
        turns = longer
    frames = [{**frame, "state": world.mapping(after)} for frame, after in turns]
    for thing in allow:
        if absent(world, state, thing):
            frames += [deus(world, state, thing, c) for c in sorted(world.free - set(state))]
    return frames


def extensions(world, script, allow=()):
    state = world.state_at(script, len(script["frames"]))
    return [append(script, frame) for frame in children(world, state, allow)]


def exhaustive(world, start, T, score, allow=()):
    """(score, script): the best of all scripts of length T from `start`."""
    scripts = [new_script(world, start)]
    for _ in range(T):
        scripts = [longer for script in scripts for longer in extensions(world, script, allow)]
    return best(world, scripts, score, 1)[0]


def best(world, scripts, score, width):
    """The `width` best (score, script), best first; the earlier of equals."""
    return sorted(((score(world, s), s) for s in scripts), key=lambda pair: -pair[0])[:width]


def beam(world, starts, T, score, width=1, allow=()):
    """(score, script): the best over the starts, each with its own beam of `width` prefixes."""
    found = []
    for start in starts:
        kept = [(0.0, new_script(world, start))]
        for _ in range(T):
            longer = [x for _, script in kept for x in extensions(world, script, allow)]
            kept = best(world, longer, score, width)
        found.append(kept[0])
    return max(found, key=lambda pair: pair[0])


# ---- The default kitchen -------------------------------------------------------------------------

KITCHEN = [
    "...#...#...",
    ".P.........",
    "...#...#...",
    "#.#######.#",
    "...#...#...",
    ".G.........",
    "...#...#...",
]


def kitchen(rows=KITCHEN, table=True, cheese=None, robot=None, robot_first=False, **settings):
    """The kitchen on any map with tiles P and G; cheese, robot: changes to the two characters."""
    marks = {mark: (x, y) for y, row in enumerate(rows) for x, mark in enumerate(row)}
    tiles = {name: marks[mark] for name, mark in (("pink", "P"), ("green", "G")) if mark in marks}
    weak = Character("cheese", 0.6, (), tuple(tiles))
    goals, rhos = (*tiles, "none"), (-3, -1, 0, 1, 3)
    strong = Character("robot", 1.0, ("cheese", "table"), goals, toward="cheese", attitude=rhos)
    pair = [replace(weak, **(cheese or {})), replace(strong, **(robot or {}))]
    objects = [Object("table", may_be_absent=True)] if table else []
    return World(rows, tiles, pair[::-1] if robot_first else pair, objects, **settings)
