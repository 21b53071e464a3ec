"""Threads that search side by side, whom an interrupt may meet anywhere.

KeyboardInterrupt is raised in the main thread, wherever it is. The standard library's executors
wait there on conditions written in Python: in the middle of one, it leaves a lock held for ever, or
becomes "cannot release un-acquired lock" (seen in both ways). Queues written in C are safe, so this
waits on nothing else.
"""

from __future__ import annotations

import _thread
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any, TypeVar

T = TypeVar("T")


class Workers:
    """So many threads. Used as a context, whose end waits for what they are doing just then."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._todo: SimpleQueue[tuple[int, Callable[[], Any]] | None] = SimpleQueue()
        self._done: SimpleQueue[tuple[int, Any, BaseException | None] | None] = SimpleQueue()

    def __enter__(self) -> Workers:
        for _ in range(self.count):
            # Not threading.Thread, which waits on a condition until it has begun.
            _thread.start_new_thread(self._work, ())
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with suppress(Empty):  # what nobody has begun is dropped
            while True:
                self._todo.get_nowait()
        for _ in range(self.count):
            self._todo.put(None)
        ended = 0
        while ended < self.count:
            ended += self._done.get() is None

    def in_turn(self, calls: Iterable[Callable[[], T]]) -> Iterator[T]:
        """What calls return, in their order. Raises what they raise."""
        asked = list(enumerate(calls))
        for each in asked:
            self._todo.put(each)
        came: dict[int, tuple[Any, BaseException | None]] = {}
        for number, _ in asked:
            while number not in came:
                done = self._done.get()
                assert done is not None, "nobody ends while it is used"
                came[done[0]] = done[1:]
            value, problem = came.pop(number)
            if problem is not None:
                raise problem
            yield value

    def _work(self) -> None:
        while (task := self._todo.get()) is not None:
            number, call = task
            try:
                self._done.put((number, call(), None))
            except BaseException as problem:
                self._done.put((number, None, problem))
        self._done.put(None)
