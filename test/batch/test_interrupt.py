"""Ctrl-C ends a batch at once, and leaves what is done."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from batch.conftest import Cell
from conventions.source_tree import ROOT

from drake_geom_ros.batch.parts import FinishedParts

PROGRAM = 'from drake_geom_ros.command_line.program import main; raise SystemExit(main())'


@pytest.mark.processes
def test_an_interrupted_command_keeps_what_is_done(tmp_path, cell):
    np.save(tmp_path / 'states.npy', cell.states(3_000_000))
    command = [sys.executable, '-c', PROGRAM, 'batch', str(Cell.path)]
    command += [str(tmp_path / 'states.npy'), '--out', str(tmp_path / 'out.npz')]
    running = subprocess.Popen(
        command,
        cwd=tmp_path,
        env={**os.environ, 'PYTHONPATH': f'{ROOT}:{os.environ.get("PYTHONPATH", "")}'},
        stderr=subprocess.PIPE,
        text=True,
    )
    parts = tmp_path / 'out.npz.parts'
    while running.poll() is None and len(list(parts.glob('*.npz'))) < 2:
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    _, errors = running.communicate(timeout=800)
    assert running.returncode == 130, errors
    assert 'interrupted; --resume goes on' in errors
    done = list(parts.glob('*.npz'))
    assert 2 <= len(done) < len(json.loads((parts / 'task.json').read_text())['blocks'])
    assert all('distance' in np.load(each) for each in done)


def test_an_interrupt_while_a_part_is_written_leaves_it_whole(tmp_path, monkeypatch):
    parts = FinishedParts(tmp_path / 'out.npz', {'job': 'x'}, [(0, 2), (2, 4)])
    assert parts.begin(resume=False) == [(0, 2), (2, 4)]
    savez = np.savez

    def interrupted(file, **arrays):
        signal.raise_signal(signal.SIGINT)
        savez(file, **arrays)

    monkeypatch.setattr(np, 'savez', interrupted)
    with pytest.raises(KeyboardInterrupt):
        parts.put((0, 2), {'distance': np.array([1.0, 2.0])})
    assert parts.get((0, 2))['distance'].tolist() == [1.0, 2.0]
    assert parts.begin(resume=True) == [(2, 4)]
