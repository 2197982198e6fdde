"""The page of contact surfaces: its example and its table are what is printed."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.processes

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / 'docs/contact_surfaces.md').read_text()


def printed(*arguments):
    run = subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, check=True, cwd=ROOT
    )
    return run.stdout.strip()


def test_the_examples_print_what_is_said():
    code, of_states, _of_a_node = re.findall(r'```python\n(.*?)```', PAGE, re.S)
    first, second = printed('-c', code + of_states).splitlines()
    assert f'`{first}`' in PAGE
    assert f'`{second}`' in PAGE


def test_the_table_is_that_of_the_example(tmp_path):
    (table,) = re.findall(r'```text\n( *opening.*?)```', PAGE, re.S)
    picture = tmp_path / 'patch.png'
    assert printed('examples/grasp_patch.py', '--picture', str(picture)) == table.strip()
    assert picture.stat().st_size > 1000


def test_check_tells_of_the_scene_file_what_is_said(tmp_path):
    (scene,) = re.findall(r'```yaml\n(.*?)```', PAGE, re.S)
    (told,) = re.findall(r'```text\n(contact surfaces.*?)```', PAGE, re.S)
    path = tmp_path / 'scene.yaml'
    path.write_text(scene)
    assert told in printed('-m', 'drake_geom_ros', 'check', str(path)) + '\n'
