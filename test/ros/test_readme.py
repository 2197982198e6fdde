"""The README's client against a real node: it prints what the README says."""

import subprocess
import sys

from ros.harness import ROOT, environment, start_node


def test_the_client_prints_what_the_readme_says(tmp_path):
    node = start_node(tmp_path / 'log', scene_file='scenes/minimal.yaml', max_distance=1.0)
    try:
        done = subprocess.run(
            [sys.executable, 'examples/ask_the_node.py'],
            env=environment(),
            cwd=ROOT,
            capture_output=True,
            text=True,
            timeout=120,
        )
    finally:
        node.end()
    assert done.returncode == 0, done.stderr + node.output()
    assert f'```\n{done.stdout}```' in (ROOT / 'README.md').read_text()
