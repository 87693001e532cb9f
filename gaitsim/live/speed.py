"""The current speed of a search."""

import time
from collections import deque
from collections.abc import Callable
from typing import Any

Clock = Callable[[], float]


class Speed:
    """Evaluations and generations per second, over the last few seconds.

    Args:
        recent: number of seconds to average over.
        clock: function that returns the time in seconds from any origin.
    """

    def __init__(self, recent: float, clock: Clock = time.monotonic) -> None:
        self._recent, self._clock = recent, clock
        self._counts: deque[tuple[float, int, int]] = deque()

    def add(self, generation: int, evaluations: int) -> None:
        """Record the numbers of the last generation and of evaluations so far."""
        now = self._clock()
        self._counts.append((now, generation, evaluations))
        while len(self._counts) > 2 and now - self._counts[1][0] >= self._recent:
            self._counts.popleft()

    def clear(self) -> None:
        """Discard the counts, such as before a pause."""
        self._counts.clear()

    def per_second(self) -> dict[str, Any]:
        """Return both speeds by their keys in a snapshot; 0 while the search is idle."""
        evaluations = generations = 0.0
        if len(self._counts) > 1:
            (start, first, before), (end, last, after) = self._counts[0], self._counts[-1]
            passed = max(end - start, 1e-9)
            evaluations, generations = (after - before) / passed, (last - first) / passed
        return {"evaluations_per_second": evaluations, "generations_per_second": generations}
