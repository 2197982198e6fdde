"""What the tests cost: ``--costs=FILE`` writes a table by folder, kind and file.

Each phase of a test adds its wall time [s] and the processor time [s] of its process and of the
children that ended in it. A node's processor time counts in the test that ends the node. Every run
prints how many kernels were compiled, in children too, and names those that were compiled twice.
Functions that kernels call are compiled into each process's own kernels, and into no cache.
"""

from __future__ import annotations

import os
import tempfile
from collections import Counter, defaultdict
from pathlib import Path

import pytest

KINDS = ('packaging', 'processes', 'topics', 'clock')  # marks, the dearest first
PURE = 'pure'
COMPILES = 'compiles'
SHOWN = 10  # names of functions that were compiled twice


def processor_time():
    """Return the processor time of this process and of its ended children [s]."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


class Meter:
    """Notes in each report what the phase cost: in the process that runs the tests."""

    def __init__(self):
        self._before = processor_time()
        self.compiled = 0

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item, call):
        report = yield
        now = processor_time()
        report.processor_seconds = now - self._before
        self._before = now
        report.compiled, self.compiled = self.compiled, 0
        report.kind = kind_of(item)
        return report


def kind_of(item):
    """Return the kind of a test by its marks."""
    return next((kind for kind in KINDS if item.get_closest_marker(kind)), PURE)


class Table:
    """Adds up the reports of all workers and writes the table when the run ends."""

    def __init__(self, file):
        self._file = Path(file)
        self._tests = {}

    def pytest_runtest_logreport(self, report):
        cost = self._tests.setdefault(report.nodeid, [PURE, 0.0, 0.0, 0])
        cost[0] = getattr(report, 'kind', PURE)
        cost[1] += report.duration
        cost[2] += getattr(report, 'processor_seconds', 0.0)
        cost[3] += getattr(report, 'compiled', 0)

    def pytest_sessionfinish(self):
        lines = []
        for title, key in (('folder', folder_of), ('kind', self._kind), ('file', file_of)):
            lines += self._rows(title, key)
        self._file.parent.mkdir(parents=True, exist_ok=True)
        self._file.write_text('\n'.join(lines) + '\n')

    def _kind(self, nodeid):
        kind, compiled = self._tests[nodeid][0], self._tests[nodeid][3]
        return COMPILES if kind == PURE and compiled else kind

    def _rows(self, title, key):
        sums = defaultdict(lambda: [0, 0.0, 0.0, 0])
        for nodeid, (_, seconds, processor_seconds, compiled) in self._tests.items():
            for name in (key(nodeid), 'all'):
                row = sums[name]
                row[0] += 1
                row[1] += seconds
                row[2] += processor_seconds
                row[3] += compiled
        yield f'| {title} | tests | seconds | processor seconds | compiled functions |'
        yield '|---|---|---|---|---|'
        for name, (count, *times, compiled) in sorted(sums.items(), key=lambda row: -row[1][1]):
            yield f'| {name} | {count} | {times[0]:.0f} | {times[1]:.0f} | {compiled} |'
        yield ''


def folder_of(nodeid):
    """Return the folder below test/ that a test is in, two levels deep at most."""
    parts = Path(nodeid.partition('::')[0]).parts[1:-1]
    return '/'.join(parts[:2]) or '.'


def file_of(nodeid):
    """Return the file that a test is in."""
    return nodeid.partition('::')[0]


class Journal:
    """Reads what all processes of a run compiled, from the file that the package writes."""

    VARIABLE = 'DRAKE_GEOM_ROS_COMPILE_LOG'

    def __init__(self):
        descriptor, name = tempfile.mkstemp(prefix='compiled-')
        os.close(descriptor)
        self._file = Path(name)
        os.environ[self.VARIABLE] = name

    def pytest_terminal_summary(self, terminalreporter):
        rows = [tuple(line.split('\t')[1:]) for line in self._file.read_text().splitlines()]
        kept = [row for row in rows if row[0]]
        twice = [row for row, count in Counter(kept).items() if count > 1]
        terminalreporter.write_line(
            f'kernels compiled for a cache: {len(kept)}, of these twice: {len(twice)}; '
            f'functions compiled into them: {len(rows) - len(kept)}'
        )
        functions = sorted({function for _, function, _ in twice})
        if functions:
            more = f' and {len(functions) - SHOWN} more' if len(functions) > SHOWN else ''
            terminalreporter.write_line(f'twice: {", ".join(functions[:SHOWN])}{more}')

    def pytest_unconfigure(self):
        self._file.unlink(missing_ok=True)


def pytest_addoption(parser):
    parser.addoption('--costs', metavar='FILE', help='write a table of what the tests cost')


def pytest_configure(config):
    is_worker = hasattr(config, 'workerinput')
    if not is_worker:
        config.pluginmanager.register(Journal(), 'compile-journal')
    file = config.getoption('--costs')
    if file is None:
        return
    meter = Meter()
    config.pluginmanager.register(meter, 'costs-meter')
    count_compiled_functions(meter)
    if not is_worker:
        config.pluginmanager.register(Table(file), 'costs-table')


def count_compiled_functions(meter):
    """Count what is compiled in this process, and not what the cache on disk has."""
    from numba.core import event

    class CompiledFunctions(event.Listener):
        def on_start(self, event):
            meter.compiled += 1

        def on_end(self, event):
            pass

    event.register('numba:compile', CompiledFunctions())
