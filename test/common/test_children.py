"""A child is asked to end, and killed where it does not."""

import signal
import subprocess
import sys

import pytest

from drake_geom_ros.common.children import end

pytestmark = pytest.mark.processes

OBEDIENT = 'signal.signal(signal.SIGTERM, lambda *_: sys.exit(3))'
OBSTINATE = 'signal.signal(signal.SIGTERM, signal.SIG_IGN)'


@pytest.mark.parametrize(
    ('answer', 'grace', 'code'), [(OBEDIENT, 100.0, 3), (OBSTINATE, 0.1, -signal.SIGKILL)]
)
def test_a_child_ends_as_asked_or_is_killed(answer, grace, code):
    script = (
        f'import signal, sys\n{answer}\nprint("ready", flush=True)\nwhile True: signal.pause()'
    )
    child = subprocess.Popen([sys.executable, '-c', script], stdout=subprocess.PIPE)
    assert child.stdout.readline() == b'ready\n'
    assert end(child, grace) == code
    assert end(child, grace) == code  # it is over
    child.stdout.close()
