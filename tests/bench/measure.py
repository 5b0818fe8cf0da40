"""How the bench measures renders: medians of several runs, taken in turns."""

import statistics
import time
from collections.abc import Callable


def side_by_side(works: dict[str, Callable[[], object]], runs: int = 5) -> dict[str, float]:
    """Median wall times of several works that take turns, so that a busy machine disturbs all of them alike; one more
    turn at the beginning warms up."""
    for work in works.values():
        work()
    times: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(runs):
        for name, work in works.items():
            start = time.perf_counter()
            work()
            times[name].append(time.perf_counter() - start)
    return {name: statistics.median(values) for name, values in times.items()}
