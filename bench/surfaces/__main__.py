"""What contact surfaces cost, and how right they are.

::

    python -m bench.surfaces resolution            # error, time, memory: docs/accuracy/surfaces.md
    python -m bench.surfaces hunt --minutes 5      # bodies flush, touching, and within each other

Times are compared in turns in one process; do not quote them.
"""

from __future__ import annotations

import argparse
import logging
import sys


def main() -> int:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest='command', required=True)
    commands.add_parser('resolution', help='what resolution_hint costs, into docs/accuracy')
    memory = commands.add_parser('memory', help='print what a body takes, for resolution')
    memory.add_argument('package')
    memory.add_argument('scene')
    memory.add_argument('hint', type=float)
    hunting = commands.add_parser('hunt', help='look for answers that break a law')
    hunting.add_argument('--minutes', type=float, default=5.0)
    hunting.add_argument('--seed', type=int, default=0)
    options = parser.parse_args()
    logging.getLogger('drake').setLevel(logging.ERROR)
    if options.command == 'hunt':
        from bench.surfaces import hunt

        return hunt.run(options.minutes, options.seed)
    from bench.surfaces import resolution  # needs matplotlib

    if options.command == 'memory':
        resolution.tell_memory(options.package, options.scene, options.hint)
    else:
        resolution.run()
    return 0


if __name__ == '__main__':
    sys.exit(main())
