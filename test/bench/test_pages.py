"""Pages: tables, and the machine without its name, or anybody's."""

import getpass
import os
import socket

from bench.pages import description, table, versions
from truth import peers


def test_processor_and_cores_but_no_names():
    text = description()
    assert f'{os.cpu_count()} cores' in text
    assert socket.gethostname() not in text
    assert getpass.getuser() not in text.split()


def test_versions_of_what_answers():
    found = versions(peers.installed())
    assert {'Python', 'numpy', 'numba', *peers.installed()} <= set(found)


def test_tables():
    assert (
        table(('a', 'b'), [(1, 'x'), ('y', 2.5)])
        == '| a | b |\n| --- | --- |\n| 1 | x |\n| y | 2.5 |\n'
    )
    assert table(('a', 'b', 'c'), [], left=1) == '| a | b | c |\n| --- | ---: | ---: |\n'
