"""Threads that work side by side, and what an interrupt does to them."""

from __future__ import annotations

import random
import signal
import threading
import time
from collections.abc import Callable
from functools import partial

import pytest

from i2pdsl.search.workers import Workers


def slowly(seconds: float, value: int) -> int:
    time.sleep(seconds)
    return value


def test_results_come_in_the_order_of_the_calls() -> None:
    with Workers(2) as workers:
        calls = [partial(slowly, 0.02 if k % 2 else 0.0, k) for k in range(10)]
        assert list(workers.in_turn(calls)) == list(range(10))
        assert list(workers.in_turn([lambda: 7])) == [7]
        assert list(workers.in_turn([])) == []


def test_what_goes_wrong_in_a_thread_is_raised() -> None:
    calls: list[Callable[[], float]] = [lambda: 1.0, lambda: 1 / 0, lambda: 3.0]
    with pytest.raises(ZeroDivisionError), Workers(2) as workers:
        list(workers.in_turn(calls))


def test_they_work_at_the_same_time() -> None:
    meeting = threading.Barrier(2, timeout=60)
    with Workers(2) as workers:
        assert sorted(workers.in_turn([meeting.wait, meeting.wait])) == [0, 1]


def test_what_was_not_begun_is_dropped() -> None:
    begun: list[int] = []

    def begin(number: int) -> None:
        begun.append(number)
        time.sleep(0.01)

    with Workers(1) as workers:
        next(workers.in_turn([partial(begin, k) for k in range(1000)]))
    assert 1 <= len(begun) < 1000


def go_on(workers: Workers) -> None:
    while True:
        list(workers.in_turn([partial(sum, range(2000))] * 4))


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs a timer")
def test_interrupts_at_any_moment_come_out_as_they_are() -> None:
    """With the standard library's executor, one of some hundreds never ends (measured)."""

    def interrupt(number: int, frame: object) -> None:
        raise KeyboardInterrupt

    chance, before = random.Random(0), signal.signal(signal.SIGALRM, interrupt)
    try:
        for _ in range(300):
            signal.setitimer(signal.ITIMER_REAL, 0.002 + 0.005 * chance.random())
            with pytest.raises(KeyboardInterrupt), Workers(2) as workers:
                go_on(workers)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
