"""The page of contact surfaces: its example and its table are what is printed."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / 'docs/contact_surfaces.md').read_text()


def printed(*arguments):
    run = subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, check=True, cwd=ROOT
    )
    return run.stdout.strip()


def test_the_example_prints_what_is_said():
    (code,) = re.findall(r'```python\n(.*?)```', PAGE, re.S)
    assert f'`{printed("-c", code)}`' in PAGE


def test_the_table_is_that_of_the_example(tmp_path):
    (table,) = re.findall(r'```text\n(.*?)```', PAGE, re.S)
    picture = tmp_path / 'patch.png'
    assert printed('examples/grasp_patch.py', '--picture', str(picture)) == table.strip()
    assert picture.stat().st_size > 1000
