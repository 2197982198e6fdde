"""The example runs, tells the truth, and tells the same under pydrake where that is installed."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / 'examples' / 'register_and_query.py'

# Distances follow from the sizes: fingers 0.08 (0.056) m apart, a ball of 0.03 m radius between,
# its centre 0.05 m above the table, fingers reaching down to 0.01 m, the palm to 0.11 m.
APART = """\
  palm and ball are 0.0300 m apart
  left finger and table are 0.0100 m apart
  right finger and table are 0.0100 m apart
  ball and table are 0.0200 m apart
"""
HOLDING = """\
  left finger and ball overlap by 0.0020 m
  right finger and ball overlap by 0.0020 m
"""
EXPECTED = f"""\
5 geometries, 5 frames
7 pairs to look at
open:
  palm and ball are 0.0300 m apart
  left finger and ball are 0.0100 m apart
  left finger and table are 0.0100 m apart
  right finger and ball are 0.0100 m apart
  right finger and table are 0.0100 m apart
  ball and table are 0.0200 m apart
  any collision: False
closed:
{HOLDING}{APART}  any collision: True
holding:
{APART}  any collision: False
let go:
  filter removed: True
{HOLDING}{APART}  any collision: True
  the ball is at [0.0, 0.0, 0.05]
"""


def output(script):
    """Return what a script prints; it must end well."""
    environment = {**os.environ, 'PYTHONPATH': str(ROOT)}
    done = subprocess.run(
        [sys.executable, str(script)], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_it_tells_the_truth():
    assert output(SCRIPT) == EXPECTED


@pytest.mark.skipif(not importlib.util.find_spec('pydrake'), reason='pydrake is not installed')
def test_pydrake_says_the_same(tmp_path):
    translated = tmp_path / SCRIPT.name
    translated.write_text(SCRIPT.read_text().replace('from drake_geom_ros', 'from pydrake'))
    assert output(translated) == EXPECTED
