"""What was measured, as docs/effects.md."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from typing import Any

from bench.effects.rungs import RATE, Rung
from drake_geom_ros.evidence.pages import table, three

Result = dict[str, Any]
STEPS = ('core', 'numba', 'scene files', 'scene', 'compile', 'first query')
INTRODUCTION = """# Only the effects a scene calls for

A ladder of scenes, from two spheres upwards, and what each makes this package import, compile,
allocate, compute and publish: what a scene does not call for does not happen. Written by
`python -m bench.effects`; `test/effects` holds the counts true.
"""
IMPORTED = """## Imported

Packages of others that each step brings, beside those of the steps above it. Numba loads most of
itself at its first compiled call, and with it whatever it finds of SciPy; trimesh, at a scene's
first hull or mesh, whatever it finds of its friends, python-fcl among them.
"""
COMPILED = """## Compiled

Kernels that the scene's pairs of shapes need; each is compiled when a scene first has such a pair,
and kept on disk. *Cold*: the cache was empty before the first rung, and each rung compiled what
those above it had not: the sum of the rungs up to one is what its first start ever can take.
*Warm*: everything loaded from the cache. Both with what Numba itself takes; memory is what is
resident after the first query.
"""
STARTED = """## Start-up and memory

Seconds of each step with a warm cache, in a new process each time; medians. *numba*: its first
compiled call, with nothing to do. Memory is what is resident after the first query, without ROS.
"""
COMPUTED = """## Computed

Counts of `QueryObject.effects()` for the signed distances within 0.1 m: of the first query, of one
after everything that moves has moved, and of one after nothing has. *looked at*: pairs that the
broad phase holds; of these *filtered*, *far* (kept apart by bounds, or by how little they moved)
and *kept* (both rest: the last answer stands) reach no kernel. Times are of posing and query,
medians.
"""
ALLOCATED = """## Allocated

What a context of the scene holds after 100 cycles, and the most that a moving cycle takes beside
it, results included: allocations of Python and NumPy. Role-less geometry takes a line in the
model, and nothing in a cycle.
"""
PUBLISHED = """## Published

The real node in a process of its own, {rate:g} pose messages a second for {seconds:g} s.
*start*: from the start of the process to its scene on `~/scene`, cache warm. *processor*: its time
for each pose message, everything included. *ran* and *not*: effects that `~/cycle_report` tells,
with the median count and [us] of a cycle, for cases that subscribe to it.
"""
NO_ROS = """## Published

Left out: the messages or ROS cannot be imported here ({reason}).
"""


def scenes(ladder: Sequence[Rung]) -> str:
    """Return the table of what the rungs are."""
    return table(('scene', 'what it is'), [(r.name, r.says) for r in ladder])


def median(results: list[Result], *path: str) -> float:
    """Return the median of a number in all results."""

    def value(result: Any) -> Any:
        for key in path:
            result = result[key]
        return result

    return statistics.median(map(value, results))


def imported(
    ladder: Sequence[Rung],
    warm: dict[str, list[Result]],
    packages: Callable[[list[str]], set[str]],
) -> str:
    """Return the table of packages; ``packages`` names those of modules."""
    first = warm[ladder[0].name][0]['modules']
    rows, known = [], set[str]()
    titles = {'core': '`import drake_geom_ros.geometry`', 'numba': 'the first compiled call',
              'scene files': '`import drake_geom_ros.scene_files`'}  # fmt: skip
    for step, title in titles.items():
        rows.append((title, _listed(packages(first[step]) - known)))
        known |= packages(first[step])
    for rung in ladder:
        modules = warm[rung.name][0]['modules']
        later = [name for step in modules if step not in titles for name in modules[step]]
        rows.append((rung.name, _listed(packages(later) - known)))
    return table(('step or scene', 'brings'), rows)


def _listed(names: set[str]) -> str:
    return ', '.join(sorted(names, key=str.lower)) or 'nothing'


def compiled(
    ladder: Sequence[Rung], cold: dict[str, Result], warm: dict[str, list[Result]]
) -> str:
    rows = []
    for rung in ladder:
        results = warm[rung.name]
        kernels = ', '.join(f'`{name.partition(".")[2]}`' for name in results[0]['kernels'])
        here = cold.get(rung.name)
        row = (str(here['functions']), *_taken([here])) if here else ('-', '-', '-')
        rows.append((rung.name, *row, *_taken(results), kernels))
    headings = ('functions', 'cold [s]', '[MB]', 'warm [s]', '[MB]', 'kernels')
    return table(('scene', *headings), rows, left=1)


def _taken(results: list[Result]) -> tuple[str, str]:
    """Return seconds and megabytes of getting ready to compute."""
    seconds = sum(median(results, 'seconds', step) for step in ('numba', 'compile'))
    return three(seconds), three(median(results, 'memory', 'first query'))


def started(ladder: Sequence[Rung], warm: dict[str, list[Result]]) -> str:
    rows = []
    for rung in ladder:
        results = warm[rung.name]
        seconds = [median(results, 'seconds', step) for step in STEPS]
        memory = median(results, 'memory', 'first query')
        in_order = (*map(three, seconds[:-1]), three(1e3 * seconds[-1]), three(sum(seconds)))
        rows.append((rung.name, *in_order, three(memory)))
    steps = (f'{step} [s]' for step in STEPS[:-1])
    return table(('scene', *steps, 'first query [ms]', 'all [s]', 'memory [MB]'), rows, left=1)


def computed(ladder: Sequence[Rung], warm: dict[str, list[Result]]) -> str:
    rows = []
    for rung in ladder:
        results = warm[rung.name]
        for which, effects in results[0]['effects'].items():
            methods = effects['pairs_by_method']
            taken = '-' if which == 'first' else three(1e6 * median(results, 'cycle', which))
            rows.append(
                (
                    f'{rung.name}, {which}',
                    f'{effects["frames_moved"]}, {effects["geometries_updated"]}',
                    *(str(effects[f'{n}_pairs']) for n in ('broadphase', 'filtered', 'far')),
                    str(effects['cached_pairs']),
                    ', '.join(f'{n} {name}' for name, n in methods.items()) or '0',
                    taken,
                )
            )
    columns = ('scene, query', 'frames, geometries moved', 'looked at', 'filtered', 'far')
    return table((*columns, 'kept', 'computed', '[us]'), rows, left=1)


def allocated(ladder: Sequence[Rung], warm: dict[str, list[Result]]) -> str:
    rows = [
        (rung.name, *(three(median(warm[rung.name], 'allocated', k)) for k in ('held', 'cycle')))
        for rung in ladder
    ]
    return table(('scene', 'context [kB]', 'a cycle [kB]'), rows, left=1)


def published(cases: Sequence[tuple[Any, Result]]) -> str:
    """Return the table of the node's cases."""
    rows = []
    for case, result in cases:
        received = ', '.join(f'{t} {rate:.0f}' for t, rate in result['received'].items())
        ran = [
            f'{name} {count:g} ({1e6 * seconds:.0f})'
            for name, (count, seconds, reason) in result['effects'].items()
            if not reason
        ]
        rows.append(
            (
                f'{case.rung}: {case.says}',
                f'{result["start"]:.1f}',
                f'{result["memory"]:.0f}',
                three(1e3 * result['processor'] / RATE),
                received or 'nothing',
                ', '.join(ran) or '-',
                _not_run(result['effects']) or '-',
            )
        )
    headings = ('case', 'start [s]', 'memory [MB]', 'processor [ms]')
    return table((*headings, 'received [1/s]', 'ran', 'not, and why'), rows, left=1)


def _not_run(effects: dict[str, tuple[float, float, str]]) -> str:
    """Return what did not run, by reason."""
    names: dict[str, list[str]] = {}
    for name, (_, _, reason) in effects.items():
        if reason:
            names.setdefault(reason, []).append(name)
    return '; '.join(f'{", ".join(all)}: {reason}' for reason, all in names.items())
