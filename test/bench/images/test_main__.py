"""bench.images: one script under both imports, whose images are the same but at silhouettes."""

import importlib.util
import json
import subprocess
import sys

import pytest
from conventions.source_tree import ROOT

pytestmark = pytest.mark.processes


@pytest.mark.skipif(importlib.util.find_spec('pydrake') is None, reason='no pydrake')
def test_images_are_those_of_pydrake_but_at_silhouettes(tmp_path):
    output = tmp_path / 'difference.json'
    # In a process of its own: without the graphics libraries VTK ends it by a fault.
    done = subprocess.run(
        [sys.executable, '-m', 'bench.images', '--compare', '--out', str(output)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=800,
        check=False,
    )
    if done.returncode < 0:
        pytest.skip(f'VTK found no graphics library: signal {-done.returncode}')
    assert done.returncode == 0, done.stderr
    found = json.loads(output.read_text())
    assert found['of_the_rest_away_from_silhouettes'] == 0
    assert found['pixels_of_other_label'] - found['of_these_of_one_depth'] < 1000
    # Its capsules are tessellated.
    assert found['median_depth_difference_m'] < 1e-6
    assert found['largest_depth_difference_m'] < 0.004
