"""The project beside its peers: set all poses, ask a query, read the results as arrays.

    python -m bench.peers                              # everything; about 20 minutes
    python -m bench.peers --quick spheres arms         # scenes whose names begin so
    python -m bench.peers --queries near all --variant full --paces robot
    NUMBA_NUM_THREADS=1 python -m bench.peers          # what one thread gives
    python -m bench.peers --sizes                      # 1000 to 100 000 balls instead

Writes peers.md and peers.png, or sizes.md and sizes.png, into --out. Figures of one run can be
compared, figures of two cannot. Variants: ``full`` (all bodies move), ``tenth`` (a tenth does),
``apart`` (nothing touches; for has_collisions). Paces: slow, robot (10 mm a cycle), jump (every
pose new).
"""

from __future__ import annotations

import argparse
from pathlib import Path

from bench.peers import scenes, sizes
from bench.peers.motion import PACES
from bench.peers.run import Run

ROOT = Path(__file__).resolve().parents[2]
VARIANTS = {'full': '', 'tenth': scenes.TENTH, 'apart': scenes.SPREAD}


def arguments() -> argparse.Namespace:
    """Return the command line, checked."""
    parser = argparse.ArgumentParser(
        prog='bench.peers', description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    known = ' '.join(scenes.FULL)
    parser.add_argument('scenes', nargs='*', help=f'beginnings of names, of: {known}')
    parser.add_argument('--queries', nargs='+', choices=scenes.QUERIES, default=scenes.QUERIES)
    parser.add_argument('--variant', nargs='+', choices=VARIANTS, default=list(VARIANTS))
    parser.add_argument('--paces', nargs='+', choices=PACES, default=PACES)
    parser.add_argument('--quick', action='store_true', help='a fifth of the time, no first calls')
    parser.add_argument('--seconds', type=float, help='of each query of each scene (1)')
    parser.add_argument('--sizes', action='store_true', help='what size costs, of balls only')
    parser.add_argument('--out', type=Path, default=ROOT / 'out/bench', help='folder')
    given = parser.parse_args()
    given.seconds = given.seconds or (0.2 if given.quick else 1.0)
    given.names = [
        name
        for name in scenes.names()
        if (not given.scenes or name.startswith(tuple(given.scenes)))
        and any(name.partition('/')[2] == VARIANTS[v].lstrip('/') for v in given.variant)
    ]
    for text in given.scenes:
        if not any(name.startswith(text) for name in scenes.FULL):
            parser.error(f'no scene begins with {text!r}; there are: {known}')
    return given


def measure_sizes(seconds: float, folder: Path) -> None:
    """Measure scenes of more and more balls, and write what was measured until interrupted."""
    growth = sizes.Growth(seconds)
    try:
        for count in sizes.SIZES:
            growth.size(count)
    except KeyboardInterrupt:
        print('interrupted: what was measured until now is written')
    growth.write(folder)


def main() -> None:
    """Measure, and write what was measured even when interrupted."""
    given = arguments()
    given.out.mkdir(parents=True, exist_ok=True)
    if given.sizes:
        measure_sizes(given.seconds, given.out)
        return
    run = Run(given.seconds, given.queries, given.quick, given.paces)
    try:
        for name in given.names:
            run.scene(name)
        run.growth(given.names)
        if not given.quick:
            run.first_calls()
    except KeyboardInterrupt:
        print('interrupted: what was measured until now is written')
    run.write(given.out)


if __name__ == '__main__':
    main()
