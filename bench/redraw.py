"""Draws the pictures of docs/accuracy anew whose measurements are kept, without measuring.

./run exec python -m bench.redraw
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any, get_type_hints

from bench.accuracy import arms, cell, lengths, overview
from bench.motion import costs, costs_page
from bench.stopping import options

FOLDER = Path(__file__).resolve().parents[1] / 'docs/accuracy'
# The type of a row, and what draws rows, by the name of the picture and of its table.
PICTURES: dict[str, tuple[Any, Any]] = {
    'cell': (cell.Row, cell.draw),
    'motions': (costs.Cost, costs_page.draw),
    'stopping_options': (options.Row, options.draw),
}


def rows_of(kind: Any, path: Path) -> list[Any]:
    """Return the lines of a CSV file as records of a class, whose fields name its columns."""
    types = get_type_hints(kind)
    with path.open(newline='', encoding='utf-8') as file:
        return [
            kind(**{name: types[name](text) for name, text in line.items()})
            for line in csv.DictReader(file)
        ]


def main() -> None:
    """Draw all of them."""
    for name, (kind, draw) in PICTURES.items():
        draw(rows_of(kind, FOLDER / f'{name}.csv'), FOLDER / f'{name}.png')
        print(FOLDER / f'{name}.png')
    tables = (
        rows_of(kind, FOLDER / f'{name}.csv')
        for name, kind in {'lengths': lengths.Row, 'arms': arms.Row}.items()
    )
    overview.draw(*tables, FOLDER / overview.PICTURE)
    print(FOLDER / overview.PICTURE)


if __name__ == '__main__':
    main()
