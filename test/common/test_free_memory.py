"""What the limits of a process leave it: a process that has a limit, and one that has none."""

import math
import subprocess
import sys

import pytest

pytestmark = pytest.mark.processes

TAKES = """
import resource, sys
from drake_geom_ros.common.free_memory import free_memory
print(free_memory())
used = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + 2**28, resource.RLIM_INFINITY))
print(free_memory())
kept = bytearray(2**26)
print(free_memory())
"""


@pytest.mark.skipif(not sys.platform.startswith('linux'), reason='limits are read as on Linux')
def test_it_is_what_the_limit_leaves():
    output = subprocess.run([sys.executable, '-c', TAKES], capture_output=True, check=True).stdout
    without, with_limit, later = map(float, output.split())
    assert without == math.inf
    assert with_limit == pytest.approx(2**28, rel=0.05)
    assert with_limit - later == pytest.approx(2**26, rel=0.05)
