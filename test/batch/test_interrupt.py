"""Ctrl-C ends a batch at once, and leaves what is done."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
from batch.conftest import Cell
from conventions.source_tree import ROOT

PROGRAM = 'from drake_geom_ros.command_line.program import main; raise SystemExit(main())'


def test_an_interrupted_command_keeps_what_is_done(tmp_path, cell):
    np.save(tmp_path / 'states.npy', cell.states(3_000_000))
    command = [sys.executable, '-c', PROGRAM, 'batch', str(Cell.path)]
    command += [str(tmp_path / 'states.npy'), '--output', str(tmp_path / 'out.npz')]
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
    _, errors = running.communicate(timeout=60)
    assert running.returncode == 130, errors
    assert 'interrupted; --resume goes on' in errors
    done = list(parts.glob('*.npz'))
    assert 2 <= len(done) < len(json.loads((parts / 'task.json').read_text())['blocks'])
    assert all('distance' in np.load(each) for each in done)
