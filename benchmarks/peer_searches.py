"""The search, by all of them; called by `peers.py`."""

from __future__ import annotations

from functools import partial
from typing import Any
from unittest import mock

import numpy as np
from peer_arrays import Clock, Times, clocked
from peer_beliefs import believed_plainly
from peer_plain import plain_state, plain_world
from peer_report import HAND, NUMPY, OURS, PLAIN, Given, Report


def searches(report: Report, given: Given, policies: Any, small: bool) -> None:
    import peer_jax
    import peer_numpy

    from i2pdsl.computing import computing
    from i2pdsl.objective.terms import story_objective
    from i2pdsl.search import beam
    from i2pdsl.search.beam import beam_search

    a, a32, (weak, strong), (weak32, strong32) = given.arrays, *policies
    objective = story_objective(given.story.typed, given.world)
    starts, length = given.starts, given.length
    doubles = Doubles(given, objective)

    def ours(width: int, least: float = beam.BRIEF_SECONDS) -> Any:
        """As by default, or compiled as long searches are."""
        with computing(), mock.patch.object(beam, "BRIEF_SECONDS", least):
            found = beam_search(given.world, objective, length, starts, width, ())
        order = np.empty(len(given.arrays.weak_next[0]), int)
        order[found.starts] = np.arange(len(found.starts))
        return found.scores[order[starts]], found.actions[order[starts]]

    def in_numpy(width: int) -> Any:
        size = max(1, 256 // width)
        parts = [
            peer_numpy.search(a, weak, strong, starts[i : i + size], length, width, given.offspring)
            for i in range(0, len(starts), size)
        ]
        return tuple(np.concatenate(part) for part in zip(*parts, strict=True))

    for width in (1, 10):
        size = (length, width, given.offspring)
        works = {
            OURS: partial(ours, width),
            HAND: partial(peer_jax.search, a32, weak32, strong32, starts, *size),
            NUMPY: partial(in_numpy, width),
        }
        work = f"search, {'greedy' if width == 1 else f'beam of {width}'}"
        clocks = clocked(works, 5 if width == 1 else 3)
        report.add_all(work, clocks)
        if small:
            lasting = clocked({OURS: partial(ours, width, 0.0)}, 3)[OURS]
            report.add(f"{work}, compiled to last", OURS, lasting.times)
        found = {who: clock.result for who, clock in clocks.items()}
        if small and width == 1:
            some = starts[::4]
            world = plain_world(given.world.spec)
            believed_plainly(world, given, given.scripts[0])  # all is planned
            clock = Clock(partial(_searched_plainly, world, given, some))
            clock.run()
            t = clock.times
            scaled = Times(t.cpu * len(starts) / len(some), t.wall * len(starts) / len(some), 0, 0)
            report.add(work, PLAIN, scaled, f"{len(some)} of {len(starts)} starts, in proportion")
            far = np.abs(clock.result - found[NUMPY][0][::4]).max()
            report.check(
                f"Greedy search in plain Python, from {len(some)} starts: scores differ from those "
                f"of NumPy by at most {far:.0e}."
            )
        check_scripts(report, given, policies, work, found)
        doubles.check(report, policies, width)
    report.add("search, as by default", OURS, _default(given), "wider beams, 12 times the work")


def check_scripts(
    report: Report, given: Given, policies: Any, work: str, found: dict[str, Any]
) -> None:
    """How the scripts of timed runs, in single precision, compare once scored in doubles."""
    import peer_numpy

    a, _, (weak, strong), _ = given.arrays, *policies
    score = {
        who: peer_numpy.scores(a, weak, strong, given.starts, np.asarray(actions))
        for who, (_, actions) in found.items()
    }
    told = []
    for who, (_, actions) in found.items():
        if who != OURS:
            same = (np.asarray(actions) == found[OURS][1]).all(1).mean()
            far = np.abs(score[who].max() - score[OURS].max())
            told.append(f"{who} {same:.0%} the same scripts, best score {far:.0e} apart")
    text = "; ".join(told)
    report.check(f"{work.capitalize()}, as timed (ours and JAX in single precision): {text}.")


class Doubles:
    """Our search in doubles, which it never is for users: to compare it with others exactly."""

    STARTS = 40

    def __init__(self, given: Given, objective: Any) -> None:
        import jax

        from i2pdsl.search.beam import _search
        from i2pdsl.worlds.grid.arrays import padded
        from i2pdsl.worlds.world import double_precision

        self.given, self.starts = given, given.starts[: self.STARTS].astype(np.int32)
        trees = (padded(given.world.tables), objective.params)
        self.arguments = jax.tree.map(double_precision, trees)
        self.run = jax.jit(partial(_search, given.world, objective, given.length, ()))

    def scores(self, width: int) -> np.ndarray:
        from i2pdsl.search.pool import Rule

        places = np.resize(np.repeat(self.starts, width), 10 * len(self.starts))
        rule = Rule(np.int32(width), np.int32(width), np.bool_(False))
        found = np.asarray(self.run(*self.arguments, places, rule)[0])
        return found[: len(self.starts) * width].reshape(-1, width).max(1)

    def check(self, report: Report, policies: Any, width: int) -> None:
        import peer_jax
        import peer_numpy

        a, (weak, strong) = self.given.arrays, policies[1]
        some = (a, weak, strong, self.starts, self.given.length, width, self.given.offspring)
        ours, told = self.scores(width), []
        for who, scores in (
            (HAND, peer_jax.search(*some)[0]),
            (NUMPY, peer_numpy.search(*some)[0]),
        ):
            same = np.abs(scores - ours) < 1e-6
            told.append(f"{who} {same.sum()}")
            if not same.all():
                told[-1] += f" (else up to {np.abs(scores - ours).max():.1g})"
        report.check(
            f"Width {width} in doubles, from {len(ours)} starts: within 1e-6 of our score are "
            f"{', '.join(told)}."
        )


def _searched_plainly(world: Any, given: Given, starts: np.ndarray) -> np.ndarray:
    import reference

    def score(world: Any, script: Any) -> float:
        found: float = reference.depict(world, script, reference.HELPS)
        return found + reference.rationality(world, script) + reference.plausibility(world, script)

    placed = [plain_state(given.world, int(s)) for s in starts]
    return np.array([reference.beam(world, [s], given.length, score)[0] for s in placed])


def _default(given: Given) -> Times:
    """The search as a story has it that says nothing of it, but for the weights."""
    from dataclasses import replace

    from i2pdsl.search.searches import SEARCHES
    from i2pdsl.search.task import Task as Asked
    from i2pdsl.worlds.kind import Watch

    typed = given.story.typed
    polish = type(typed.search)().polish
    typed = replace(typed, search=replace(typed.search, polish=polish))
    clock = Clock(lambda: SEARCHES["beam"].solve(Asked(typed, given.world, Watch()), 0, 1))
    clock.run()
    clock.run()
    return clock.times
