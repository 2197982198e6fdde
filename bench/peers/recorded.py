"""The run that docs/peers.md records, and what of a later one has fallen behind it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from bench.peers.report import HEADINGS, LIBRARIES, Measurement

PAGE = Path(__file__).resolve().parents[2] / 'docs/peers.md'
# What a row may lose: of two runs of one version, on a nearly idle machine, 3 of 328 lost more.
KEPT = 0.7

Key = tuple[str, str, str]  # scene, pace, query


def fallen(measurements: list[Measurement], page: str) -> list[str]:
    """Return a line for each row that has lost much beside pydrake since the page was recorded.

    By medians, which other work on the machine changes less than means; the first one has lost
    the most.
    """
    recorded, found = dict(ratios_of(page)), []
    for m in measurements:
        ours, pydrake = (m.taken[n].median() if n in m.taken else None for n in LIBRARIES[:2])
        then = recorded.get((m.scene, m.pace, m.query))
        if then is None or ours is None or pydrake is None:
            continue
        now = pydrake / ours
        if now < KEPT * then:
            line = f'fallen: {m.name}: {now:.3g}x pydrake, {then:.3g}x in {PAGE.name} (medians)'
            found.append((now / then, line))
    return [line for _, line in sorted(found)]


def ratios_of(page: str) -> Iterator[tuple[Key, float]]:
    """Yield the rows of the page's table with pydrake's median in times of ours."""
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.strip().strip('|').split('|')]
        times = cells[3:5]
        if len(cells) == len(HEADINGS) and all(' / ' in cell for cell in times):
            ours, pydrake = (float(cell.split(' / ')[0]) for cell in times)
            yield (cells[0], cells[1], cells[2]), pydrake / ours
