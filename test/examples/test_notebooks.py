"""Notebooks under examples/ run from the first cell to the last."""

import json
import os

import matplotlib
import pytest
from conventions.source_tree import ROOT
from every import report

NOTEBOOKS = sorted((ROOT / 'examples').rglob('*.ipynb'))
GROWN = ROOT / 'examples/grow_a_region.ipynb'
OTHERS = [path for path in NOTEBOOKS if path != GROWN]


def run(notebook):
    """Run the cells of a notebook, and return what their names stand for then."""
    names = {'__name__': '__main__'}
    for k, cell in enumerate(json.loads(notebook.read_text())['cells']):
        if cell['cell_type'] == 'code':
            source = ''.join(cell['source'])
            exec(compile(source, f'{notebook.name}, cell {k}', 'exec'), names)
    return names


@pytest.mark.everything  # blocks of pages, which test_code_blocks.py runs
@pytest.mark.processes
@pytest.mark.parametrize(
    'notebook', [path for path in NOTEBOOKS if path != GROWN], ids=lambda path: path.stem
)
def test_it_runs(notebook, monkeypatch):
    pytest.importorskip('scipy')
    pytest.importorskip('viser')
    monkeypatch.chdir(ROOT)
    matplotlib.use('Agg')
    run(notebook)


def test_no_notebook_has_stored_outputs():
    assert GROWN in NOTEBOOKS
    report(
        f'{notebook.name}, cell {k}'
        for notebook in NOTEBOOKS
        for k, cell in enumerate(json.loads(notebook.read_text())['cells'])
        if cell.get('outputs') or cell.get('execution_count') is not None
    )


def test_the_grown_region_holds_what_it_says(monkeypatch):
    monkeypatch.chdir(ROOT)
    matplotlib.use('Agg')
    names = run(GROWN)
    free, inside, boxed = names['free'], names['inside'], names['boxed']
    assert free[boxed].all(), 'the box is certified'
    assert boxed.any()
    assert inside.sum() > 10 * boxed.sum(), 'the polytope is much larger'
    assert (inside & ~free).sum() <= 0.2 * inside.sum()
    names['figure'].savefig(os.devnull, format='png')
