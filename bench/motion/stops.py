"""Random states of arms, a base and a person: whether a stop that is said to be clear is.

Dense samples of each stop, along the path and with joints that stop anywhere, are judged by exact
distances. ``python -m bench.motion stops --seed K`` are other states than of any other seed.
"""

from __future__ import annotations

import time
from collections import Counter

import numpy as np

from drake_geom_ros.stopping import Braking
from truth.judging.stops import StoppingCell

_ROUNDING = 1e-9  # [m] of sampled distances
_SHARES = (0.4, 0.8, 1.0)  # of the scale


def run(states: int, seed: int) -> int:
    """Judge; print what was found, and return 1 if any stop came too near."""
    rng, counts, began = np.random.default_rng(seed), Counter[str](), time.process_time()
    cells = [
        StoppingCell(Braking(decelerations=(2.0,), reaction_time=0.1, category=k), with_base=base)
        for k in (0, 1)
        for base in (False, True)
    ]
    for number in range(states):
        cell = cells[number % len(cells)]
        moment = cell.moment(rng)
        for arm, stop in enumerate(cell.stops(moment)):
            counts['stops'] += 1
            counts['clear'] += stop.clear
            counts['slowed'] += 0.0 < stop.scale < 1.0
            counts['wrong'] += _is_wrong(cell, moment, arm, stop, rng)
    seconds = time.process_time() - began
    print(f'seed {seed}: {dict(counts)}, {seconds:.0f} s of the processor')
    return int(counts['wrong'] > 0)


def _is_wrong(cell, moment, arm, stop, rng) -> bool:
    """Return whether a sample of a stop that is proved comes too near."""
    along = cell.braking.category == 1
    shares = [share * stop.scale for share in _SHARES if stop.scale > 0.0]
    by_itself = [cell.by_itself(moment, arm, share, rng) for share in shares]
    if not along:
        return _comes_too_near(cell, moment, arm, by_itself, None)
    on_path = [cell.along_path(moment, arm, share) for share in shares + [1.0] * bool(stop.clear)]
    return _comes_too_near(cell, moment, arm, on_path, 'no other arm') or _comes_too_near(
        cell, moment, arm, by_itself, 'the other arm'
    )


def _comes_too_near(cell, moment, arm, samples, others) -> bool:
    """Return whether any of the samples of some stops of an arm comes too near."""
    if not samples:
        return False
    went, seconds = (np.concatenate(each) for each in zip(*samples, strict=True))
    return bool(cell.worst(moment, arm, went, seconds, others) < -_ROUNDING)
