"""The work of `peers.py` in memo (https://github.com/kach/memo), in its natural and in its fastest
style. Run by `peers.py` in an interpreter that has memo, without i2pdsl:

    python benchmarks/peer_memo.py FOLDER

Natural, as its handbook and demos have it: an agent moves to a state with a probability given for
each, values are a recursion over the frames that are left, and a viewer observes one action at a
time. Fastest: arrays as parameters, states after an action looked up rather than summed over, and
the models under `jit`, `vmap`, `scan` and `while_loop`; the search is that of peer_jax.py, with
memo's posterior in it.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import peer_jax
import peer_numpy
from memo import memo
from peer_arrays import STAY, Arrays, Task, clocked

FOLDER = Path(sys.argv[1])
TASK = Task(**json.loads((FOLDER / "task.json").read_text()))
GIVEN = Arrays.load(FOLDER / "arrays.npz")
DENSE = 2000  # states up to which a table of all pairs of them is made

jax.config.update("jax_enable_x64", True)

S = jnp.arange(GIVEN.weak_next.shape[1])
A = jnp.arange(len(GIVEN.cost))
G = jnp.arange(len(GIVEN.weak_home))
P = jnp.arange(len(GIVEN.rho))
H = jnp.arange(len(GIVEN.rational))

WEAK_HOME, STRONG_HOME = jnp.asarray(GIVEN.weak_home * 1.0), jnp.asarray(GIVEN.strong_home * 1.0)
COST, GAMMA, CHANCE = jnp.asarray(GIVEN.cost), float(GIVEN.gamma), float(GIVEN.success)
WEAK_NEXT, STRONG_NEXT = jnp.asarray(GIVEN.weak_next), jnp.asarray(GIVEN.strong_next)
FACING, STRONG_GOAL = jnp.asarray(GIVEN.facing), jnp.asarray(GIVEN.strong_goal)


# ---- Planning, natural ---------------------------------------------------------------------------

if TASK.states <= DENSE:
    _eye = np.eye(TASK.states)
    _weak = CHANCE * _eye[GIVEN.weak_next] + (1 - CHANCE) * _eye  # [A, S, S]
    _strong = _eye[GIVEN.strong_next]
    WEAK_LEADS = jnp.asarray(np.einsum("asm,bmt->sat", _weak, _strong) / len(COST))


@jax.jit
def weak_leads(s, a, t):
    return WEAK_LEADS[s, a, t]


@jax.jit
def weak_paid(s, a, g):
    return WEAK_HOME[g, s] + COST[a]


@jax.jit
def gamma():
    return GAMMA


@cache
@memo
def weak_q[s: S, a: A, g: G](n):
    weak: knows(s, a, g)
    weak: given(t in S, wpp=weak_leads(s, a, t))
    weak: chooses(b in A, to_maximize=0.0 if n <= 0 else weak_q[t, b, g](n - 1))
    return E[weak_paid(s, a, g) + (0.0 if n <= 0 else gamma() * weak_q[weak.t, weak.b, g](n - 1))]


STRONG_LEADS = STRONG_PAID = None  # once the weak one's policy is known


@jax.jit
def strong_leads(s, b, p, t):
    return STRONG_LEADS[FACING[p], s, b, t]


@jax.jit
def strong_paid(s, b, p):
    return STRONG_PAID[s, b, p]


@cache
@memo
def strong_q[s: S, b: A, p: P](n):
    strong: knows(s, b, p)
    strong: given(t in S, wpp=strong_leads(s, b, p, t))
    strong: chooses(c in A, to_maximize=0.0 if n <= 0 else strong_q[t, c, p](n - 1))
    return E[
        strong_paid(s, b, p) + (0.0 if n <= 0 else gamma() * strong_q[strong.t, strong.c, p](n - 1))
    ]


def settled(model: Any) -> np.ndarray:
    """V of a recursion, once half the range of a step's change is small enough."""
    model.cache_clear()
    before = np.asarray(model(0).max(1))
    for n in range(1, 100_000):
        now = np.asarray(model(n).max(1))
        low, high = (now - before).min(0), (now - before).max(0)
        if ((high - low) / 2 <= TASK.tolerance).all():
            return before + (low + high) / 2 / (1 - GAMMA)
        before = now
    raise AssertionError("it does not settle")


def planned_naturally() -> tuple[np.ndarray, np.ndarray]:
    global STRONG_LEADS, STRONG_PAID
    weak = settled(weak_q)
    policy = peer_numpy.softmax(GIVEN, peer_numpy.q_weak(GIVEN, weak))  # [S, A, G + 1]
    answered = np.einsum("sag,ast->gst", policy, _weak)
    STRONG_LEADS = jnp.asarray(np.einsum("bsm,gmt->gsbt", _strong, answered))
    paid = np.einsum("sag,a->sg", policy, GIVEN.cost) + np.pad(GIVEN.weak_home.T, ((0, 0), (0, 1)))
    social = GIVEN.rho * paid[:, GIVEN.facing]
    own = GIVEN.strong_home[GIVEN.strong_goal].T[:, None] + GIVEN.cost[:, None]
    STRONG_PAID = jnp.asarray(own + GAMMA * social[GIVEN.strong_next.T])
    return weak, settled(strong_q)


# ---- Planning, fastest ---------------------------------------------------------------------------


@jax.jit
def weak_after(s, a):
    return WEAK_NEXT[a, s]


@jax.jit
def strong_after(s, b):
    return STRONG_NEXT[b, s]


@jax.jit
def cost(a):
    return COST[a]


@jax.jit
def only(s):
    return 0 * s


@memo
def after_any_answer[s: S](v: ...):
    weak: knows(s)
    weak: thinks[strong: knows(s), strong: chooses(b in A, wpp=1)]
    return weak[E[array_index(v, strong_after(s, strong.b))]]


@memo
def weak_best[s: S, a: A](w: ..., home: ...):
    weak: knows(s, a)
    return array_index(home, s) + cost(a) + {GAMMA} * (
        {CHANCE} * array_index(w, weak_after(s, a)) + {1 - CHANCE} * array_index(w, s)
    )


@memo
def after_answer[s: S](v: ..., policy: ..., home: ..., rho: ...):
    strong: knows(s)
    strong: thinks[weak: knows(s), weak: chooses(a in A, wpp=array_index(policy, s, a))]
    return strong[
        E[
            array_index(rho, only(s)) * (array_index(home, s) + cost(weak.a))
            + {CHANCE} * array_index(v, weak_after(s, weak.a))
            + {1 - CHANCE} * array_index(v, s)
        ]
    ]


@memo
def strong_best[s: S, b: A](w: ..., home: ...):
    strong: knows(s, b)
    return array_index(home, s) + cost(b) + {GAMMA} * array_index(w, strong_after(s, b))


def one_weak(v: Any, home: Any) -> Any:
    return weak_best(after_any_answer(v), home).max(1)


def one_strong(v: Any, home: Any, rho: Any, policy: Any, others: Any) -> Any:
    return strong_best(after_answer(v, policy, others, rho[None]), home).max(1)


# Problems stand in the last axis, so that one gather reads a state's values of all of them.
weak_sweep = jax.vmap(one_weak, in_axes=-1, out_axes=-1)
strong_sweep = jax.vmap(one_strong, in_axes=(-1, -1, 0, None, None), out_axes=-1)


def solved(sweep: Any, v: Any, given: Any) -> Any:
    """As peer_numpy.solved."""

    def go_on(carry: Any) -> Any:
        _, _, residual, _ = carry
        return residual > TASK.tolerance

    def step(carry: Any) -> Any:
        _, v, _, count = carry
        change = sweep(v, *given) - v
        low, high = change.min(0), change.max(0)
        middle = (low + high) / 2
        after = v + change + middle * GAMMA / (1 - GAMMA)
        return v + middle / (1 - GAMMA), after, (high - low).max() / 2, count + 1

    return jax.lax.while_loop(go_on, step, (v, v, jnp.inf, 0))[0]


solved_weak = jax.jit(lambda v, *given: solved(weak_sweep, v, given))
solved_strong = jax.jit(lambda v, *given: solved(strong_sweep, v, given))


def strong_problems(policy: np.ndarray) -> Any:
    """Which problems face one policy, and what they are given."""
    none = np.zeros(TASK.states)
    for facing, problems in GIVEN.blocks:
        home = jnp.asarray(GIVEN.strong_home[GIVEN.strong_goal[problems]].T * 1.0)
        others = GIVEN.weak_home[facing] * 1.0 if facing < len(G) else none
        given = (home, GIVEN.rho[problems], policy[:, :, facing], others)
        yield problems, tuple(map(jnp.asarray, given))


def planned_fast() -> tuple[np.ndarray, np.ndarray]:
    weak = np.asarray(solved_weak(jnp.zeros((TASK.states, len(G))), WEAK_HOME.T))
    policy = peer_numpy.softmax(GIVEN, peer_numpy.q_weak(GIVEN, weak))
    strong = np.empty((TASK.states, len(P)))
    for problems, given in strong_problems(policy):
        none = jnp.zeros((TASK.states, len(problems)))
        strong[:, problems] = solved_strong(none, *given)
    return weak, strong


def sweeps_of(weak: np.ndarray, strong: np.ndarray) -> Any:
    """One sweep of all problems, from values that are solved."""
    policy = peer_numpy.softmax(GIVEN, peer_numpy.q_weak(GIVEN, weak))
    each = [(p, given, jnp.asarray(strong[:, p])) for p, given in strong_problems(policy)]
    one, home, all_ = jnp.asarray(weak), WEAK_HOME.T, jax.jit(strong_sweep)
    first = jax.jit(weak_sweep)

    def sweep() -> float:
        worst = float(jnp.abs(first(one, home) - one).max())
        for _, given, v in each:
            worst = max(worst, float(jnp.abs(all_(v, *given) - v).max()))
        return worst

    return sweep


# ---- The audience --------------------------------------------------------------------------------


@memo
def believed[h: H, a: A](belief: ..., policy: ...):
    viewer: knows(h, a)
    viewer: thinks[
        one: given(h in H, wpp=array_index(belief, h)),
        one: chooses(a in A, wpp=array_index(policy, a, h)),
    ]
    viewer: observes [one.a] is a
    return viewer[Pr[one.h == h]]


@memo
def told[h: H](belief: ..., likelihood: ...):
    viewer: knows(h)
    viewer: thinks[one: given(h in H, wpp=array_index(belief, h))]
    viewer: observes_event(wpp=array_index(likelihood, one.h))
    return viewer[Pr[one.h == h]]


def forgotten(belief: Any, forgetting: Any) -> Any:
    share = forgetting / (belief.shape[-1] - 1)
    return belief * (1 - forgetting - share) + share


many_told = jnp.vectorize(told, signature="(h),(h)->(h)")


def seen(forgetting: Any, belief: Any, likelihood: Any) -> Any:
    """As peer_jax.seen."""
    return forgotten(many_told(belief, likelihood), forgetting)


def seen_naturally(a: Arrays, belief: np.ndarray, likelihood: np.ndarray) -> np.ndarray:
    """As peer_numpy.seen; one model for each row of actions."""
    rows = likelihood.reshape(-1, *likelihood.shape[-2:])
    before = np.broadcast_to(belief, (*likelihood.shape[:-2], 1, len(H))).reshape(-1, len(H))
    pairs = zip(map(jnp.asarray, before), map(jnp.asarray, rows), strict=True)
    found = [believed(b, row).T for b, row in pairs]
    return forgotten(np.array(found), a.forgetting).reshape(likelihood.shape)


def posterior_naturally(weak: Any, strong: Any, starts: Any, actions: Any) -> np.ndarray:
    """As peer_numpy.posterior; one observation after the other."""
    a, found = GIVEN, []
    for state, turns in zip(starts, actions, strict=True):
        belief, asked = np.full(len(H), 1 / len(H)), []
        for turn in [*turns, None]:
            asked.append(belief @ a.helps / (belief @ a.rational))
            if turn is None:
                break
            own, answer = divmod(int(turn), len(A))
            act, effect = (own, own) if own <= STAY else (own - STAY - 1, STAY)
            for policy, of, action, after in (
                (weak, a.weak_of, act, a.weak_next[effect, state]),
                (strong, a.strong_of, answer, a.strong_next[answer, a.weak_next[effect, state]]),
            ):
                now = believed(jnp.asarray(belief), jnp.asarray(policy[state][:, of]))
                belief, state = forgotten(np.asarray(now[:, action]), a.forgetting), after
        found.append(asked)
    return np.array(found)


def main() -> None:
    from importlib.metadata import version

    given = dict(np.load(FOLDER / "given.npz"))
    weak, strong = given["weak"], given["strong"]
    rows: dict[str, Any] = {}
    arrays: dict[str, np.ndarray] = {}

    def row(name: str, work: Any, repeats: int = 3) -> None:
        ready = lambda: jax.block_until_ready(work())
        clock = clocked({name: ready}, repeats)[name]
        rows[name], result = asdict(clock.times), clock.result
        for number, part in enumerate(result if isinstance(result, tuple) else (result,)):
            arrays[f"{name} {number}"] = np.asarray(part)

    small = TASK.states <= DENSE
    if small:
        row("plan natural", planned_naturally, 1)
        row("plan fastest", planned_fast)
    else:
        row("sweep fastest", sweeps_of(given["weak_values"], given["strong_values"]), 2)
    single = lambda x: jnp.asarray(x, jnp.float32 if x.dtype.kind == "f" else None)
    a = jax.tree.map(single, GIVEN)
    weak32, strong32 = single(weak), single(strong)
    starts, turns = jnp.asarray(given["starts"]), jnp.asarray(given["turns"])
    one = (given["starts"][:1], given["turns"][:1])
    row("one natural", lambda: posterior_naturally(weak, strong, *one))
    row("one fastest", lambda: peer_jax.posterior(a, weak32, strong32, starts[:1], turns[:1], seen))
    row("many fastest", lambda: peer_jax.posterior(a, weak32, strong32, starts, turns, seen))
    for width in TASK.widths:
        size = (TASK.length, width, TASK.offspring)
        found = lambda size=size: peer_jax.search(
            a, weak32, strong32, given["search"], *size, see=seen
        )
        row(f"search {width} fastest", found)
        if small and width == 1:
            natural = lambda size=size: peer_numpy.search(
                GIVEN, weak, strong, given["search"], *size, see=seen_naturally
            )
            row(f"search {width} natural", natural, 1)
    np.savez(FOLDER / "memo.npz", **arrays)
    python = sys.version.split()[0]
    rows["versions"] = f"memo-lang {version('memo-lang')} on JAX {jax.__version__}, Python {python}"
    (FOLDER / "memo.json").write_text(json.dumps(rows))


if __name__ == "__main__":
    main()
