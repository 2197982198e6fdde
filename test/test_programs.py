"""Programs that are interrupted before they have begun: a code, no traceback."""

import signal
import subprocess
import sys

import pytest
from conventions.source_tree import ROOT
from ros.harness import environment

pytestmark = pytest.mark.processes

# Starts a program; the first import of a library, which each of them needs, is interrupted.
INTERRUPTED = """
import signal, sys
from drake_geom_ros import programs

class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == 'numpy':
            signal.raise_signal(signal.SIGINT)

sys.meta_path.insert(0, Interrupting())
name, *sys.argv[1:] = sys.argv[1:]
sys.exit(getattr(programs, name)())
"""


def started(*arguments, **how):
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=ROOT,
        env=environment(),
        capture_output=True,
        text=True,
        timeout=800,
        check=False,
        **how,
    )


@pytest.mark.parametrize(
    ('name', 'code', 'said'),
    [
        ('drake_geom_ros query', 130, 'drake_geom_ros: interrupted\n'),
        ('scene_graph_node', 0, ''),
        ('scene_viewer', 0, ''),
        ('pose_player', 0, ''),
        ('status', 130, ''),
    ],
)
def test_an_interrupt_while_it_is_imported_is_no_traceback(name, code, said):
    done = started('-c', INTERRUPTED, *name.split())
    assert (done.returncode, done.stdout, done.stderr) == (code, '', said)


def test_where_interrupts_are_ignored_they_stay_so():
    """So does ``nohup``, and a shell with what it runs in the background."""
    ignoring = lambda: signal.signal(signal.SIGINT, signal.SIG_IGN)  # noqa: E731
    script = INTERRUPTED.replace('name)()', "name)(['query', '--help'])")
    done = started('-c', script, 'drake_geom_ros', preexec_fn=ignoring)
    assert (done.returncode, done.stderr) == (0, '')
    assert done.stdout.startswith('usage: drake_geom_ros')


def test_what_a_program_imports_is_searched_for_garbage_no_more_and_what_follows_is():
    script = """
import gc
from drake_geom_ros import programs
programs.drake_geom_ros(['query', 'scenes/minimal.yaml', '--out', '/dev/null'])
print(gc.isenabled(), gc.get_freeze_count() > len(gc.get_objects()))
"""
    assert started('-c', script).stdout == 'True True\n'
