"""What sensed maps cost.

::

    python -m bench.maps arms --states 300           # two arms, beside python-fcl and Coal
    python -m bench.maps packing                     # how long a map takes to make, and its memory
    python -m bench.maps changes                     # some cells of a map that is in a scene
    python -m bench.maps contacts --states 300       # whether a body is in contact, and how deep
    python -m bench.maps resolution                  # error, time, memory: docs/accuracy/maps.md
    python -m bench.maps stops                       # missed and false stops: accuracy/stops.md

Times are of the processor, one thread, in turns in one process: compare them, do not quote them.
"""

from __future__ import annotations

import argparse

from bench.maps import arms, changes, contacts, packing, stops


def main() -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest='command', required=True)
    racing = commands.add_parser('arms', help='distances beside those of octrees')
    racing.add_argument('--states', type=int, default=300)
    racing.add_argument('--resolution', type=float, default=0.011)
    making = commands.add_parser('packing', help='what it takes to make a map')
    making.add_argument('--counts', type=int, nargs='+', default=[100_000, 1_000_000])
    changing = commands.add_parser('changes', help='what it takes to change some cells')
    changing.add_argument('--counts', type=int, nargs='+', default=[100_000, 1_000_000])
    changing.add_argument('--changes', type=int, nargs='+', default=[1, 100, 10_000])
    touching = commands.add_parser('contacts', help='a contact beside its depth')
    touching.add_argument('--cells', type=int, default=100_000)
    touching.add_argument('--states', type=int, default=300)
    commands.add_parser('resolution', help='what resolution costs, into docs/accuracy')
    commands.add_parser('stops', help='what a scan costs a stop rule, into docs/accuracy')
    options = parser.parse_args()
    if options.command == 'arms':
        arms.run(options.states, options.resolution)
    elif options.command == 'packing':
        packing.run(options.counts)
    elif options.command == 'contacts':
        contacts.run(options.cells, options.states)
    elif options.command == 'changes':
        changes.run(options.counts, options.changes)
    elif options.command == 'stops':
        stops.run()
    else:
        from bench.maps import resolution  # needs matplotlib

        resolution.run()


if __name__ == '__main__':
    main()
