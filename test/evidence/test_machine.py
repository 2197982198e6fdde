"""The machine is described without its name, and nobody's."""

import getpass
import os
import socket

from drake_geom_ros.evidence import peers
from drake_geom_ros.evidence.machine import description, versions


def test_processor_and_cores_but_no_names():
    text = description()
    assert f'{os.cpu_count()} cores' in text
    assert socket.gethostname() not in text
    assert getpass.getuser() not in text.split()


def test_versions_of_what_answers():
    found = versions(peers.installed())
    assert {'Python', 'numpy', 'numba', *peers.installed()} <= set(found)
