"""Large blocks are given back when they are freed; garbage is searched for among few objects."""

import gc
import subprocess
import sys
import weakref

import pytest
from conventions.source_tree import ROOT

from drake_geom_ros.live.memory import leave_out_of_searches, settle

# Small blocks behind the large ones keep heaps from shrinking, as a node's other threads do.
SCRIPT = """
from pathlib import Path
from drake_geom_ros.live.memory import give_back_blocks

def memory():
    return 4096 * int(Path('/proc/self/statm').read_text().split()[1])

if {wanted}:
    assert give_back_blocks()
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
    return number_of(SCRIPT.format(wanted=wanted))


def number_of(script):
    """Return the number that a script prints."""
    output = subprocess.run(
        [sys.executable, '-c', script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return int(output.stdout)


@pytest.mark.processes
def test_freed_blocks_go_back_to_the_system():
    assert kept(False) > 100e6
    assert kept(True) < 20e6


# In glibc's heap of the main thread: Python takes blocks of this size from heaps of its own.
UNMERGED = """
import ctypes
from drake_geom_ros.live.memory import give_back_blocks

libc = ctypes.CDLL(None)
libc.malloc.restype, libc.free.argtypes = ctypes.c_void_p, [ctypes.c_void_p]

class Heap(ctypes.Structure):
    _fields_ = [(name, ctypes.c_size_t) for name in (
        'arena', 'ordblks', 'smblks', 'hblks', 'hblkhd', 'usmblks', 'fsmblks', 'uordblks',
        'fordblks', 'keepcost')]

if {wanted}:
    assert give_back_blocks()
libc.mallinfo2.restype = Heap
blocks = [libc.malloc(64) for _ in range(5000)]  # kept: freeing a large list merges all
for block in blocks:
    libc.free(block)
print(libc.mallinfo2().smblks)
"""


@pytest.mark.processes
def test_small_blocks_are_merged_when_they_are_freed_and_not_all_at_once_later():
    assert number_of(UNMERGED.format(wanted=False)) > 4000
    assert number_of(UNMERGED.format(wanted=True)) == 0


class Ring:
    """Holds itself, so that only a search for garbage frees it."""

    def __init__(self):
        self.ring = self


@pytest.fixture
def searched():
    """Search all objects again afterwards, as other tests expect."""
    thresholds = gc.get_threshold()
    yield
    gc.unfreeze()
    gc.set_threshold(*thresholds)


def test_what_is_there_is_not_searched_again(searched):
    settle()
    assert gc.get_freeze_count() > 1000 * len(gc.get_objects())


def test_what_came_since_is_left_out_as_well_and_let_go_where_nobody_has_it(searched):
    settle()
    ring = Ring()
    before, gone = gc.get_freeze_count(), weakref.ref(ring)
    leave_out_of_searches()
    assert gc.get_freeze_count() > before
    ring.ring = None
    del ring
    assert gone() is None


def test_all_is_searched_rarely_for_many_new_objects_are_no_garbage(searched):
    settle()
    count = gc.get_stats()[2]['collections']
    points = [[k] for k in range(500_000)]
    assert len(points) == 500_000
    assert gc.get_stats()[2]['collections'] == count


def test_garbage_of_afterwards_and_of_an_earlier_life_is_freed(searched):
    before = Ring()
    settle()
    after = Ring()
    gone = [weakref.ref(ring) for ring in (before, after)]
    del before, after
    gc.collect()
    assert [ring() is None for ring in gone] == [False, True]
    settle()
    assert [ring() is None for ring in gone] == [True, True]
