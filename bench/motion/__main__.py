"""What certified motion finds, and what it costs.

::

    python -m bench.motion hunt --motions 100000   # random motions against scans and closed forms
    python -m bench.motion arms --edges 2000       # arms, beside sampling, pydrake and tesseract
    python -m bench.motion pairs --motions 2000    # two bodies, beside python-fcl and tesseract
    python -m bench.motion trajectories --count 2000   # splines of controllers, beside sampling
    python -m bench.motion stops --states 100000   # stops of arms and a base, against samples
    python -m bench.motion costs --edges 500       # tolerances, levels, clearance: docs/accuracy

Tesseract is ``pip install tesseract-robotics==0.5.1``, which nothing else here needs.
Times are of the processor, one thread, in turns in one process: compare them, do not quote them.
"""

from __future__ import annotations

import argparse

from bench.motion import arms, hunt, stops, trajectories


def main() -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest='command', required=True)
    hunting = commands.add_parser('hunt', help='never clear where anything touches')
    hunting.add_argument('--motions', type=int, default=100_000)
    hunting.add_argument('--seed', type=int, default=0)
    racing = commands.add_parser('arms', help='time and verdicts beside sampling')
    racing.add_argument('--edges', type=int, default=2000)
    racing.add_argument('--step', type=float, default=0.5, help='length of an edge [rad]')
    splining = commands.add_parser('trajectories', help='verdicts about splines, and misses')
    splining.add_argument('--count', type=int, default=2000)
    splining.add_argument('--seed', type=int, default=0)
    stopping = commands.add_parser('stops', help='never clear where a stop comes too near')
    stopping.add_argument('--states', type=int, default=100_000)
    stopping.add_argument('--seed', type=int, default=0)
    pairing = commands.add_parser('pairs', help='time and verdicts of two bodies')
    pairing.add_argument('--motions', type=int, default=2000)
    costing = commands.add_parser('costs', help='what proofs cost, into docs/accuracy')
    costing.add_argument('--edges', type=int, default=500)
    options = parser.parse_args()
    if options.command == 'hunt':
        raise SystemExit(hunt.run(options.motions, options.seed))
    if options.command == 'stops':
        raise SystemExit(stops.run(options.states, options.seed))
    if options.command == 'trajectories':
        raise SystemExit(trajectories.run(options.count, options.seed))
    if options.command == 'costs':
        from bench.motion import costs_page  # needs matplotlib

        costs_page.run(options.edges)
    elif options.command == 'pairs':
        from bench.motion import pairs  # needs python-fcl and tesseract-robotics

        pairs.run(options.motions)
    else:
        arms.run(options.edges, options.step)


if __name__ == '__main__':
    main()
