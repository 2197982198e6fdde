"""Single runs, each in a process of its own, as rows of a table."""

from __future__ import annotations

from typing import Any

from bench.stopping.room import Room
from bench.stopping.simulation import Outcome, simulate
from bench.stopping.strategies import STRATEGIES

_RUN = 600.0  # [s] of one seed


def run_strategy(job: tuple[str, int]) -> dict[str, Any]:
    """Return the row of a strategy and a seed."""
    strategy, seed = job
    room = Room()
    return _row(strategy, seed, simulate(STRATEGIES[strategy](room), room, _RUN, seed))


def _row(strategy: str, seed: int, outcome: Outcome) -> dict[str, Any]:
    gone = {name: f'{seconds:.2f}' for name, seconds in outcome.gone.items()}
    return {
        'strategy': strategy,
        'seed': seed,
        'seconds': f'{outcome.seconds:g}',
        **gone,
        'contacts': outcome.contacts,
        'median_ms': f'{1e3 * outcome.cost:.3f}',
    }
