"""How the bench measures renders: medians of several runs, taken in turns."""

import statistics
import time
from collections.abc import Callable, Hashable


def side_by_side(
    works: dict[Hashable, Callable[[], object]], runs: int = 5, clock: Callable[[], float] = time.perf_counter
) -> dict[Hashable, float]:
    """Median times of several works, by `clock`, that take turns, so that a busy machine disturbs all of them alike;
    one more turn at the beginning warms up."""
    for work in works.values():
        work()
    times: dict[Hashable, list[float]] = {name: [] for name in works}
    for _ in range(runs):
        for name, work in works.items():
            start = clock()
            work()
            times[name].append(clock() - start)
    return {name: statistics.median(values) for name, values in times.items()}
