"""What every page of figures has: tables, legends, and where and with what they were taken.

Nothing names the machine or its owner.
"""

from __future__ import annotations

import csv
import os
import platform
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from importlib import metadata
from pathlib import Path
from typing import Any

from truth import peers

# M. Okabe and K. Ito, *Color Universal Design*: distinct in all common colour blindness.
PALETTE = ('#0072b2', '#e69f00', '#56b4e9', '#d55e00', '#404040')


def table(
    headings: Sequence[str], rows: Iterable[Sequence[object]], left: int | None = None
) -> str:
    """Return a Markdown table; columns after the first ``left`` are to the right, if given."""
    right = 0 if left is None else len(headings) - left
    marks = ['---'] * (len(headings) - right) + ['---:'] * right
    lines = (headings, marks, *rows)
    return ''.join(f'| {" | ".join(map(str, line))} |\n' for line in lines)


def write_rows(path: Path, rows: Sequence[Any]) -> None:
    """Write records to a CSV file, with six digits of a float."""
    with path.open('w', newline='') as file:
        writer = csv.DictWriter(file, fieldnames=list(asdict(rows[0])), lineterminator='\n')
        writer.writeheader()
        for row in rows:
            items = asdict(row).items()
            writer.writerow({k: f'{v:.6g}' if isinstance(v, float) else v for k, v in items})


def legend_below(figure: Any, columns: int) -> None:
    """Give a picture of one or several panels one legend below them, with each label once."""
    handles = {
        label: handle
        for axes in figure.axes
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        handles.values(), handles.keys(), loc='outside lower center', ncol=columns, frameon=False
    )


def three(value: float) -> str:
    """Return a number in three digits, of a large one all before the point."""
    return f'{value:.0f}' if value >= 100 else f'{value:.3g}'


def description() -> str:
    """Return the processor's model, the number of cores and the system, in one line."""
    return f'{processor()}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}'


def versions(peer_names: Sequence[str]) -> dict[str, str]:
    """Return the versions of Python, of what our answers depend on, and of the peers."""
    found = {'Python': platform.python_version()}
    found |= {name: metadata.version(name) for name in ('numpy', 'numba', 'scipy', 'mpmath')}
    return found | {name: peers.version(name) for name in peer_names}


def processor() -> str:
    """Return what the machine says that its processor is."""
    try:
        with open('/proc/cpuinfo', encoding='utf-8') as file:
            for line in file:
                if line.startswith('model name'):
                    return line.partition(':')[2].strip()
    except OSError:  # another system than Linux
        pass
    return platform.processor() or 'unknown processor'
