"""What accuracy costs in time, for us and for peers: ``python -m bench.accuracy``."""

import argparse
import sys
from collections.abc import Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path

from drake_geom_ros.geometry import ArgumentError, GeometryError
from truth import peers

NEEDED = ('scipy', 'mpmath', 'matplotlib')
NONE = 'none'
BAD_INPUT = 2  # the exit code of what was asked wrongly, as argparse has it


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure as the arguments say and return the exit code; 2 for what cannot be measured."""
    options = parsed(arguments)
    try:
        return run(options)
    except (GeometryError, OSError) as error:
        print(f'accuracy: {error}', file=sys.stderr)
        return BAD_INPUT


def parsed(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Return the command line, checked."""
    parser = argparse.ArgumentParser(
        prog='accuracy',
        description='Measures errors against an independent truth and times, of each pair of '
        'shapes at each accuracy level, of whole scenes, and of the peers that are installed, in '
        'about 9 minutes. Writes README.md, measurements.csv and diagrams. Exit code 1 where an '
        'error_bound was below the error or wider than its level promises.',
    )
    parser.add_argument('--quick', action='store_true', help='less of everything, in a minute')
    parser.add_argument(
        '--out',
        metavar='DIR',
        help='default: docs/accuracy, with --quick or --cases out/accuracy',
    )
    parser.add_argument(
        '--cases', nargs='+', default=[], metavar='NAME', help="as 'Box-*'; without: all"
    )
    parser.add_argument(
        '--peers',
        nargs='+',
        choices=(*peers.names(), NONE),
        metavar='NAME',
        help=f'of {", ".join(peers.names())}, or {NONE}; default: all that are installed',
    )
    parser.add_argument('--minutes', type=_minutes, help='to measure in (default: 9; quick: 0.8)')
    parser.add_argument(
        '--samples', type=_count, metavar='N', help='of each configuration of a case, at most'
    )
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument(
        '--scene',
        type=Path,
        metavar='FILE',
        help='only print what each accuracy would cost for the pairs of this scene, as it begins',
    )
    return parser.parse_args(arguments)


def run(options: argparse.Namespace) -> int:
    """Measure and return the exit code; raises GeometryError for what cannot be measured."""
    if options.scene is not None:
        from bench.accuracy.own_scene import costs_of_scene

        print('\n'.join(costs_of_scene(options.scene)))
        return 0
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise GeometryError(
            f'accuracy needs {" and ".join(missing)}, which is not installed here: '
            f'pip install {" ".join(missing)} (requirements/test.txt and demo.txt have versions)'
        )
    # Only now: nothing else needs what these import.
    from bench.accuracy.run import Request
    from bench.accuracy.run import run as measure

    request = Request(
        output=output_of(options),
        peers=peers_of(options.peers),
        patterns=options.cases,
        quick=options.quick,
        minutes=options.minutes,
        seed=options.seed,
        samples=options.samples,
    )
    return measure(request, partial(print, flush=True))


def output_of(options: argparse.Namespace) -> Path:
    """Return the folder to write to."""
    if options.out:
        return Path(options.out)
    tree = Path(__file__).parents[2]
    if not options.quick and not options.cases:
        return tree / 'docs' / 'accuracy'
    return Path('out') / 'accuracy'


def peers_of(names: list[str] | None) -> tuple[str, ...]:
    """Return the peers to ask; raises ArgumentError for one that is not installed."""
    installed = peers.installed()
    if names is None:
        return installed
    asked = tuple(name for name in peers.names() if name in names)
    for name in asked:
        if name not in installed:
            here = ', '.join(installed) or 'no peer'
            raise ArgumentError(f'--peers {name}: it is not installed; installed here: {here}')
    return asked


def _count(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f'{text} must be a number >= 1')
    return value


def _minutes(text: str) -> float:
    value = float(text)
    if not 0.0 < value < float('inf'):
        raise argparse.ArgumentTypeError(f'{text} must be minutes > 0')
    return value


if __name__ == '__main__':
    sys.exit(main())
