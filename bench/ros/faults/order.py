"""One fault after the other; which ones, and what is random in each, a seed fixes."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable

from bench.ros.faults import clients, inputs, limits
from bench.ros.faults.site import Site

FAULTS: tuple[Callable[[Site], str], ...] = (
    *(clients.burst, clients.killed_clients, clients.stopped_subscriber, clients.leases),
    *(inputs.parameter_at_its_end, inputs.hostile_request, inputs.clock_jumps, inputs.cleanup),
    *((inputs.tf_flood,) if inputs.HAS_TF else ()),
    *(limits.few_descriptors, limits.full_disk, limits.little_memory, limits.stopped_node),
)


class Faults:
    """Does faults at a site, numbered from ``first``: each can be done again by its number."""

    def __init__(self, site: Site, seed: int, first: int = 1) -> None:
        self._site, self._seed, self._next = site, seed, first
        self.counts: Counter[str] = Counter()

    def do_one(self) -> list[str]:
        """Do a fault, and return what was not as it should be."""
        number, self._next = self._next, self._next + 1
        self._site.random = random.Random(f'{self._seed} {number}')
        fault = self._site.random.choice(FAULTS)
        name = fault.__name__
        self.counts[name] += 1
        print(f'fault {number}: {name}', flush=True)
        try:
            problem = fault(self._site)
        except TimeoutError as error:
            problem = str(error)
        return [f'{name}, fault {number}: {problem}'] if problem else []


def listed(counts: Counter[str]) -> str:
    """Return how many of each in words."""
    return ', '.join(f'{n} {name.replace("_", " ")}' for name, n in sorted(counts.items()))
