"""Large blocks are given back when they are freed, also where one was freed before."""

import subprocess
import sys

from conventions.source_tree import ROOT

# Small blocks behind the large ones keep heaps from shrinking, as a node's other threads do.
SCRIPT = """
from pathlib import Path
from drake_geom_ros.ros.memory import give_back_large_blocks

def memory():
    return 4096 * int(Path('/proc/self/statm').read_text().split()[1])

if {wanted}:
    assert give_back_large_blocks()
first = bytearray(30_000_000)
del first
before = memory()
large, small = [], []
for _ in range(12):
    large.append(bytearray(b'x') * 20_000_000)
    small.append([bytearray(b'x') * 5000 for _ in range(100)])
del large
print(memory() - before)
"""


def kept(wanted):
    """Return how much memory [bytes] a process keeps of 240 MB that it freed."""
    script = SCRIPT.format(wanted=wanted)
    output = subprocess.run(
        [sys.executable, '-c', script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return int(output.stdout)


def test_freed_blocks_go_back_to_the_system():
    assert kept(False) > 100e6
    assert kept(True) < 20e6
