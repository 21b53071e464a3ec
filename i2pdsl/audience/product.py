"""A belief that is not multiplied out: what was believed before an action was observed, and how
likely the action is. A search looks at many actions of the same moment, and asks of most of them
for a few sums only."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from i2pdsl.audience.filter import Spread, share_after

Array = Any


class Product(NamedTuple):
    """P(H) once an action was observed, where who acts solves one of Q problems under each
    hypothesis. A sum over hypotheses is one over the problems, with what the hypotheses of each
    come to before the action: that is the same for all actions.

    Attributes:
        before: P(H) before it, [..., O, H].
        likely: P(action | problem), [..., O, Q]; all may be so many times as large.
        hypotheses: those of each problem, one-hot [O, Q, H].
        spread: how each observer forgets afterwards (filter.spread_of).
    """

    before: Array
    likely: Array
    hypotheses: Array
    spread: Spread | None

    def by_problem(self, weights: Array) -> Array:
        """The sums of P(H) times weights [H] over the hypotheses of each problem, [..., O, Q]."""
        after = self._kept(weights) * (self.likely / self._total[..., None])
        return after + self._lost(weights)

    def summed(self, weights: Array) -> Array:
        """The sum of P(H) times weights [H], [..., O]."""
        after = (self._kept(weights) * self.likely).sum(-1) / self._total
        return after + self._lost(weights).sum(-1)

    def multiplied(self) -> Array:
        """P(H), [..., O, H]."""
        likely = of_each(lambda o, them: self.likely[..., o, :] @ them, self.hypotheses)
        return share_after(self.before, likely, self.spread)

    def of(self, viewers: slice) -> Product:
        """The same of some of the observers."""
        spread = None
        if self.spread is not None:
            spread = self.spread[0][viewers], self.spread[1][viewers]
        before, likely = self.before[..., viewers, :], self.likely[..., viewers, :]
        return Product(before, likely, self.hypotheses[viewers], spread)

    def each(self, change: Callable[..., Array], *others: Product) -> Product:
        """The same with the arrays changed that have leading axes, given those of others."""
        before = change(self.before, *(other.before for other in others))
        return self._replace(
            before=before, likely=change(self.likely, *(other.likely for other in others))
        )

    @property
    def _total(self) -> Array:
        return (self._of_problems(self.hypotheses) * self.likely).sum(-1)

    def _kept(self, weights: Array) -> Array:
        """The sums of what was believed before, as far as it is not forgotten."""
        if self.spread is not None:
            each, other = self.spread
            weights = (1 - each - other) * weights
        # They are the same for all beliefs, which are many: they go into the small matrix.
        return self._of_problems(self._weighed(weights))

    def _lost(self, weights: Array) -> Array:
        """The sums of what is believed since something was forgotten."""
        other = 0.0 if self.spread is None else self.spread[1]
        return self._weighed(other * weights).sum(-1)

    def _weighed(self, weights: Array) -> Array:
        """The hypotheses of each problem, [O, Q, H], with weights [H] or [O, H]."""
        return weights[..., None, :] * self.hypotheses

    def _of_problems(self, hypotheses: Array) -> Array:
        return of_each(lambda o, them: self.before[..., o, :] @ them.T, hypotheses)


def of_each(product: Callable[[int, Array], Array], hypotheses: Array) -> Array:
    """Products with those of each observer, [O, Q, H], side by side: [..., O, any]. Compilers make
    more of products of matrices than of a sum over three axes."""
    found = [product(o, hypotheses[o]) for o in range(len(hypotheses))]
    return hypotheses.__array_namespace__().stack(found, axis=-2)


def multiplied(share: Array | Product) -> Array:
    """P(H), [..., O, H], of a belief held either way."""
    return share.multiplied() if isinstance(share, Product) else share
