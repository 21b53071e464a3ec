"""The page's panel of reasons: what moved which belief in the frame that the player shows.

Without scripts all frames are told, one after the other; the player hides all but one.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from i2pdsl.render.markup import plain
from i2pdsl.render.reasons import Account, Change, Observation, frames_in_words

LINKS = 6  # of the moments that moved viewers most
LEAST = 0.05  # of a probability: less is no such moment


def why_section(account: Account) -> str:
    """The section, as HTML."""
    moments: dict[int, list[Observation]] = {}
    for seen in account.observations:
        moments.setdefault(seen.first, []).append(seen)
    legend = re.sub("`(.*?)`", r"“\1”", "; ".join(account.legend))
    told = "\n".join(_moment(each) for each in moments.values())
    return f"""\
  <section class="why" aria-labelledby="why-heading">
    <div class="mind-head">
      <h2 id="why-heading">Why viewers believe it</h2>
      <p class="hint">{plain(legend)}.</p>
    </div>
    <div class="why-parts">
      <ol id="reasons">
{_start(account)}
{told}
      </ol>
{_links(account)}
    </div>
  </section>"""


def _start(account: Account) -> str:
    """What viewers are asked, before anything has moved."""
    asked = "".join(
        f"<li><b>{plain(_number(each.before))}</b> <span>{plain(each.claim)}"
        f"{f' <code>{plain(each.formal)}</code>' if each.formal else ''}</span></li>"
        for each in account.asked
    )
    said = "What viewers are asked, and believe before anybody has moved"
    return _item(0, 0, "start", f'<p class="seen">{said}</p><ul>{asked}</ul>')


def _moment(together: Sequence[Observation]) -> str:
    first = together[0]
    return _item(first.first, first.last, frames_in_words(first), "".join(map(_seen, together)))


def _item(first: int, last: int, name: str, told: str) -> str:
    return (
        f'<li data-first="{first}" data-last="{last}">'
        f'<h3><button type="button" data-frame="{last}">{name}</button></h3>{told}</li>'
    )


def _seen(seen: Observation) -> str:
    if seen.is_event:
        return f'<p class="seen">{plain(seen.seen)} <small>from which nobody learns</small></p>'
    notes = [] if seen.expected is None else [f"expected with {plain(_number(seen.expected))}"]
    notes += [] if seen.changes else ["changes next to nothing"]
    changes = "".join(map(_change, seen.changes))
    return f'<p class="seen">{plain(seen.seen)} <small>{", ".join(notes)}</small></p>' + (
        f"<ul>{changes}</ul>" if changes else ""
    )


def _change(change: Change) -> str:
    told = change.ratio
    if change.instead is not None:
        action, expected, otherwise = change.instead
        told += (
            f"; had it been “{action}” (expected with {_number(expected)}): {_number(otherwise)}"
        )
    elif change.is_forgotten:
        told += "; they forget faster than that tells them"
    return (
        f"<li><b>{plain(_moved(change))}</b> "
        f"<span>{plain(change.claim)}<small>{plain(told)}</small></span></li>"
    )


def _links(account: Account) -> str:
    """Buttons that go to the moments that moved viewers most."""
    moved = [seen for seen in account.observations if seen.changes and _size(seen) >= LEAST]
    most = sorted(sorted(moved, key=_size, reverse=True)[:LINKS], key=lambda seen: seen.first)
    if not most:
        return ""
    return f"""\
      <nav aria-labelledby="most-heading">
        <h3 id="most-heading">What moved them most</h3>
        <ol class="steps">
{chr(10).join(_lines(most))}
        </ol>
      </nav>"""


def _lines(most: Sequence[Observation]) -> Iterable[str]:
    for seen in most:
        change = seen.changes[0]
        told = f"{change.claim}, {_moved(change)}"
        deed = f"{seen.seen}: " if seen.expected is not None else ""
        yield (
            f'<li><button type="button" data-first="{seen.first}" data-frame="{seen.last}">'
            f"<span>{frames_in_words(seen)}</span> {plain(deed + told)}</button></li>"
        )


def _size(seen: Observation) -> float:
    """The greatest change that an observation made."""
    return abs(seen.changes[0].after - seen.changes[0].before)


def _moved(change: Change) -> str:
    return f"{_number(change.before)} → {_number(change.after)}"


def _number(p: float) -> str:
    """A probability as the page's curves have it, but never 0 for what is possible."""
    return "< 0.001" if 0 < p < 0.0005 else f"{p:.3f}"
