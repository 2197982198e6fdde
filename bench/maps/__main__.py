"""What sensed maps cost.

::

    python -m bench.maps arms --states 300           # two arms, beside python-fcl and Coal
    python -m bench.maps packing                     # how long a map takes to make, and its memory
    python -m bench.maps resolution                  # error, time, memory: docs/accuracy/maps.md

Times are of the processor, one thread, in turns in one process: compare them, do not quote them.
"""

from __future__ import annotations

import argparse

from bench.maps import arms, packing


def main() -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest='command', required=True)
    racing = commands.add_parser('arms', help='distances beside those of octrees')
    racing.add_argument('--states', type=int, default=300)
    racing.add_argument('--resolution', type=float, default=0.0125)
    making = commands.add_parser('packing', help='what it takes to make a map')
    making.add_argument('--counts', type=int, nargs='+', default=[100_000, 1_000_000])
    commands.add_parser('resolution', help='what resolution costs, into docs/accuracy')
    options = parser.parse_args()
    if options.command == 'arms':
        arms.run(options.states, options.resolution)
    elif options.command == 'packing':
        packing.run(options.counts)
    else:
        from bench.maps import resolution  # needs matplotlib

        resolution.run()


if __name__ == '__main__':
    main()
