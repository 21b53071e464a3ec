"""The numbers of audiences that hold factors (audience/factors.py), made of a world's hypotheses.

What is hidden about those whom others model is one factor, of as many values as their minds have
combinations; beside each of these every other character has a factor of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from i2pdsl.audience.factors import Factors, FactorTables
from i2pdsl.audience.particles import Index
from i2pdsl.worlds.minds import Rows, Seen, Space


@dataclass(frozen=True)
class Tree:
    """Joint hypotheses as one factor of several parts, and one of each other part beside it.

    Attributes:
        common, own: the numbers of the parts (of characters, in the order of acting).
        minds: the minds of the common parts in each of its values, [M, parts].
        possible: which minds of each other part there are beside each value, [M, K] each.
    """

    common: tuple[int, ...]
    own: tuple[int, ...]
    minds: np.ndarray
    possible: tuple[np.ndarray, ...]

    @property
    def size(self) -> int:
        """How many probabilities it takes."""
        return len(self.minds) + sum(int(each.any(0).sum()) * len(each) for each in self.possible)


def tree_of(space: Space, common: Sequence[int]) -> Tree:
    """The factors of a space of hypotheses, of whose parts some are modelled by others.

    Beside these a part's minds must not depend on who else is rational.
    """
    parts = range(len(space.parts))
    own = tuple(c for c in parts if c not in common)
    bits = space.flag
    found, beside = [], []
    for minds in product(*(range(len(space.parts[c])) for c in common)):
        group = sum(int(bits[c, mind]) for c, mind in zip(common, minds, strict=True))
        if all(space.possible[group, c, mind] for c, mind in zip(common, minds, strict=True)):
            found.append(minds)
            beside.append(group)
    groups = np.array(beside, dtype=int)
    possible = []
    for c in own:
        every = np.arange(len(space.parts[c]))
        possible.append(space.possible[groups[:, None] + bits[c, every], c, every])
    values = np.array(found, dtype=int).reshape(len(found), -1)
    return Tree(tuple(common), own, values, tuple(possible))


def factor_tables(space: Space, rows: Rows, seen: Seen, tree: Tree) -> FactorTables:
    """The numbers of an observer, whose prior and knowledge are products (priors.factorises)."""
    joint = _Joint(space, rows, tree)
    weight = seen.prior / rows.counts
    held = float((rows.counts * seen.known).sum())
    first = joint.factors(weight)
    return FactorTables(
        common=first.common,
        own=first.own,
        even=joint.factors(seen.known.astype(float)),
        anew=np.array(seen.forgetting * held / (held - 1) if held > 1 else 0.0),
        problems=tuple(joint.problem(index) for index in seen.problems),
        columns=seen.columns,
        class_of=joint.class_of,
        classes=tuple(map(_one_hot, joint.class_of)),
        groups=_one_hot(joint.group_of),
        members=_members(joint.group_of),
        rows=joint.rows,
        row_of=joint.row_of,
    )


class _Joint:
    """Points: values of the common factor, and classes of the minds of every other part.

    Attributes:
        group_of: the class of each value of the common factor, [M]; class_of: of each mind, [K].
        row_of: the row of each point, [C_1, ..., C_k, M]; H where there is none.
        rows: a place of each row among the combinations of classes, [H].
    """

    def __init__(self, space: Space, rows: Rows, tree: Tree) -> None:
        self._tree = tree
        digits, table, count = rows.index.digits, rows.index.table, len(rows.counts)
        of_common = self._of_common(rows.index)
        self.group_of = _numbered(of_common)
        own_digits = [digits[c, : len(space.parts[c])] for c in tree.own]
        self.class_of = tuple(map(_numbered, own_digits))
        own = list(zip(tree.possible, self.class_of, strict=True))
        # How many minds of each class there are beside each value, [M, C].
        self._sizes = [there @ _one_hot(mine) for there, mine in own]
        place, possible = of_common, np.ones(len(tree.minds), bool)
        parts = list(zip(own_digits, self.class_of, self._sizes, strict=True))
        for numbers, mine, size in reversed(parts):
            held = size.T > 0
            axes = (len(held), *(1,) * (possible.ndim - 1), len(tree.minds))
            first = _first(numbers, mine).reshape(-1, *(1,) * possible.ndim)
            place, possible = place + first, possible & held.reshape(axes)
        self.row_of = np.where(possible, table[place], count)
        sizes = (*self.row_of.shape[:-1], int(self.group_of.max()) + 1)
        *classes, value = np.indices(self.row_of.shape)
        flat = np.ravel_multi_index((*classes, self.group_of[value]), sizes)
        self.rows = np.zeros(count + 1, int)
        self.rows[self.row_of.reshape(-1)] = flat.reshape(-1)
        self.rows = self.rows[:-1]

    def factors(self, weight: np.ndarray) -> Factors:
        """P(m), and P(h_i | m), where hypotheses have weights [H] as their rows have. Beside what
        is impossible all are alike."""
        sizes, count = self._sizes, len(self._sizes)
        points = np.append(weight, 0.0)[self.row_of]
        for i, size in enumerate(sizes):
            points = points * size.T.reshape(*(1,) * i, -1, *(1,) * (count - i - 1), len(size))
        common = points.sum(tuple(range(count)))
        own = []
        for i, (there, mine) in enumerate(zip(self._tree.possible, self.class_of, strict=True)):
            by_class = points.sum(tuple(axis for axis in range(count) if axis != i)).T
            each = np.where(sizes[i] > 0, by_class / np.maximum(sizes[i], 1), 0.0)[:, mine] * there
            each = np.where(each.sum(-1, keepdims=True) > 0, each, there)
            own.append(each / each.sum(-1, keepdims=True))
        return Factors(common / common.sum(), tuple(own))

    def _of_common(self, index: Index) -> np.ndarray:
        """What the common parts add to the place of a hypothesis in an index, [M]."""
        minds, common = self._tree.minds, np.array(self._tree.common, dtype=int)
        found: np.ndarray = index.digits[common, minds].sum(-1, dtype=int)
        return found

    def problem(self, index: Index) -> np.ndarray:
        """The problem of who acts, by an index of its hypotheses: [M] or [M, K]."""
        tree, digits, place = self._tree, index.digits, self._of_common(index)
        for c, there in zip(tree.own, tree.possible, strict=True):
            if digits[c].any():  # whose problem it is
                return index.table[place[:, None] + digits[c, : there.shape[1]]]
        return index.table[place]


def _numbered(values: np.ndarray) -> np.ndarray:
    """The class of each of some values, in the order in which they come."""
    known: dict[int, int] = {}
    return np.array([known.setdefault(int(value), len(known)) for value in values])


def _first(values: np.ndarray, classes: np.ndarray) -> np.ndarray:
    """A value of each class."""
    return np.array([values[int(np.argmax(classes == n))] for n in range(classes.max() + 1)])


def _members(classes: np.ndarray) -> np.ndarray:
    """Those of each class, [classes, most]; their number where there are fewer."""
    each = [np.flatnonzero(classes == n) for n in range(classes.max() + 1)]
    found = np.full((len(each), max(map(len, each))), len(classes))
    for row, members in zip(found, each, strict=True):
        row[: len(members)] = members
    return found


def _one_hot(classes: np.ndarray) -> np.ndarray:
    """Which class each is, [n, classes], in doubles."""
    return (classes[:, None] == np.arange(classes.max() + 1)).astype(float)
