"""The examples run, tell the truth, and the same under pydrake where that is installed."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.processes

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / 'examples'

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
REGISTER_AND_QUERY = f"""\
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
# Balls of radius 0.6 m, 1 m apart, overlap by 0.2 m; which are reported follows from the filters.
TRANSIENT_FILTERS = """\
at first                               [[0, 1], [1, 2], [2, 3], [3, 4]] depths [0.2]
persistent: nothing within 0, 1, 2     [[2, 3], [3, 4]] depths [0.2]
transient 1: 3 touches nobody          [] depths []
transient 2: 2 touches 1 and 3         [[1, 2], [2, 3]] depths [0.2]
history: True
transient 1 removed                    [[1, 2], [2, 3], [3, 4]] depths [0.2]
active: False True
persistent filters wait until the history is gone
transient 2 removed                    [[2, 3], [3, 4]] depths [0.2]
persistent: all allowed again          [[0, 1], [1, 2], [2, 3], [3, 4]] depths [0.2]
"""
# The ball is at 0.6 (cos 0.5, sin 0.5), the edge of the box at (0.7, 0.65): the distance is
# hypot(0.17345, 0.362345) - 0.1, and its derivatives are those of that formula.
AUTODIFF_GRADIENTS = """\
distance     [0.30172] [[-0.350738, 0.43177]]
normal       [-0.43177  -0.901984  0.      ] [[-1.093035, -2.02523], [0.523224, 0.969456], [0.0, 0.0]]
point to box [0.40172] [[-0.350738, 0.43177]]
position     [0.52655  0.287655 0.05    ] [[-0.287655, 0.0], [0.52655, 0.0], [0.0, 0.0]]
"""  # noqa: E501
EXPECTED = {
    'autodiff_gradients.py': AUTODIFF_GRADIENTS,
    'register_and_query.py': REGISTER_AND_QUERY,
    'transient_filters.py': TRANSIENT_FILTERS,
}


def output(script, *arguments):
    """Return what a script prints; it must end well."""
    paths = [str(ROOT), *filter(None, [os.environ.get('PYTHONPATH')])]
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(paths)}
    command = [sys.executable, str(script), *arguments]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize('name', EXPECTED)
def test_it_tells_the_truth(name):
    assert output(EXAMPLES / name) == EXPECTED[name]


def test_a_body_descends_out_of_its_collision():
    told = output(EXAMPLES / 'out_of_a_collision.py').splitlines()
    assert told[0].startswith('step 0: 2 contacts, -0.06')
    assert told[-1] == 'out of collision: True'
    assert len(told) < 30


def test_a_path_is_found_at_its_clearance(tmp_path):
    pytest.importorskip('matplotlib')
    picture = tmp_path / 'path.png'
    assert output(EXAMPLES / 'around_obstacles.py', str(picture)).splitlines() == [
        'straight: -0.170 m of the posts at the nearest',
        'planned: 0.050 m of the posts at the nearest',
        'found: True',
    ]
    assert picture.stat().st_size > 10_000


def test_an_arm_reaches_down_and_keeps_its_distance():
    lines = output(EXAMPLES / 'inverse_kinematics.py').splitlines()
    assert lines[0].startswith('Optimization terminated successfully')
    clearance = float(lines[1].split()[1])
    assert 0.0199 < clearance < 0.022  # the constraint of 2 cm is active


def test_a_path_is_optimised_until_it_is_proved():
    straight, optimised, check = output(EXAMPLES / 'optimise_a_path.py', '60').splitlines()
    assert straight == 'straight: clearance -0.090 m'
    assert float(optimised.split('certified ')[1].split()[0]) > 0.003
    assert check.startswith('check_path: clear')


@pytest.mark.everything
@pytest.mark.skipif(not importlib.util.find_spec('pydrake'), reason='pydrake is not installed')
@pytest.mark.parametrize('name', EXPECTED)
def test_pydrake_says_the_same(tmp_path, name):
    translated = tmp_path / name
    translated.write_text(
        (EXAMPLES / name).read_text().replace('from drake_geom_ros', 'from pydrake')
    )
    assert output(translated) == EXPECTED[name]
