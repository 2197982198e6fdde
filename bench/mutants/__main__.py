"""Whether the tests would notice a fault: random mutants of the code, and which go unnoticed.

    ./run mutants [FILE ...] [--sample 100] [--seed 1]

Each file's share of the sample is that of its mutants. One that hangs a test is noticed too, and
is told for a look at why. A survivor is a test that is missing, or
it changes nothing that matters: then it belongs to test/mutants/equivalent.yaml, with the reason.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

os.environ['NUMBA_DISABLE_JIT'] = '1'  # before anything imports Numba

from bench.mutants import equivalents, trials
from bench.mutants.mutations import Mutant, mutants_of, sample
from bench.mutants.trials import ROOT

OURS = ROOT / 'drake_geom_ros/geometry'
KEPT = ROOT / 'out/mutants'  # which test runs which line


def files_of(names: list[str]) -> list[Path]:
    """Return the files of what was named, folders with all below; by default kernels and model."""
    paths = [Path(name).resolve() for name in names] or [
        OURS / '_proximity',
        OURS / 'model/_model.py',
    ]
    found = [path for each in paths for path in (each.rglob('*.py') if each.is_dir() else [each])]
    return sorted(path for path in found if path.name not in ('__init__.py', 'tolerances.py'))


def try_all(
    mutants: list[Mutant], items: list[Any], most: int, counts: Counter[tuple[str, str]]
) -> None:
    """Try mutants with the tests there are, tell of the survivors, and count the ends by file."""
    data = trials.measure(KEPT)
    listed = equivalents.load(equivalents.LIST)
    start = time.monotonic()
    for k, mutant in enumerate(mutants):
        file, code = mutant.file.relative_to(ROOT), mutant.code()
        said, ids = mutant.says(code), trials.tests_of(data, mutant.file, mutant.line)
        if equivalents.is_listed(listed.get(str(file), {}), said):
            end = 'equivalent'
        else:
            end = trials.end_of(mutant.file, code, ids, items, most)
        if end in (trials.HUNG, trials.SURVIVED):
            print(f'{file}:{mutant.line}, run by {len(ids)} tests: {end}', flush=True)
            print(f'        {said}', flush=True)
        counts[str(file), end] += 1
        if (k + 1) % 25 == 0:
            print(f'{k + 1} of {len(mutants)}, {time.monotonic() - start:.0f} s', flush=True)


def table(counts: Counter[tuple[str, str]]) -> str:
    """Return a table of the ends by file."""
    ends = (trials.NOTICED, trials.HUNG, 'equivalent', trials.SURVIVED)
    files = sorted({file for file, _ in counts})
    rows = [(file, *(counts[file, end] for end in ends)) for file in files]
    rows.append(('all', *(sum(counts[file, end] for file in files) for end in ends)))
    width = max(len(row[0]) for row in rows)
    lines = [f'{"file":{width}}' + ''.join(f'{end:>12}' for end in ends)]
    lines += [f'{name:{width}}' + ''.join(f'{n:12}' for n in numbers) for name, *numbers in rows]
    return '\n'.join(lines)


def main() -> int:
    """Return 1 where a mutant survived or an entry of the list is stale, else 0."""
    parser = argparse.ArgumentParser(prog='./run mutants', description=__doc__.splitlines()[0])
    parser.add_argument('files', nargs='*', help='files and folders; else kernels, filters, model')
    parser.add_argument('--sample', type=int, default=100, help='how many mutants to try')
    parser.add_argument('--seed', type=int, default=1, help='of the choice')
    parser.add_argument(
        '--tests', type=int, default=10**6, help='of other files, for a mutant: for a first look'
    )
    options = parser.parse_args()
    files = files_of(options.files)
    chosen = sample([m for file in files for m in mutants_of(file)], options.sample, options.seed)
    print(f'{len(chosen)} mutants of {len(files)} files, seed {options.seed}')
    trials.measure(KEPT)
    counts: Counter[tuple[str, str]] = Counter()
    trials.with_tests_collected(lambda items: try_all(chosen, items, options.tests, counts))
    print(table(counts))
    old = [
        f'{file}: {each}'
        for file, reasons in equivalents.load(equivalents.LIST).items()
        for each in equivalents.stale(reasons, (ROOT / file).read_text())
    ]
    for each in old:
        print(f'no longer in the code, but listed as equivalent: {each}')
    return 1 if old or any(end == trials.SURVIVED for _, end in counts) else 0


if __name__ == '__main__':
    sys.exit(main())
