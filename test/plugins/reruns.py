"""Tests of processes, topics and clocks that fail run again, each alone, after all others.

A race is named and not lost: one that passes alone is ``flaky``, the run stays green, and its name
and the reason of the first failure are the last lines. More than five, or one that fails again, is
red. Tests without these marks are pure: they never run again.
"""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from plugins.marks import RACY

MOST = 5  # more tests than that have a reason in common
PATIENCE = 1000.0  # [s] for one test with its node
NO_RERUNS = '--no-reruns'


@dataclass
class Failure:
    """The first failure of a test, in whichever phase it was."""

    report: pytest.TestReport
    passes_alone: bool = False

    @property
    def nodeid(self) -> str:
        return self.report.nodeid

    @property
    def is_racy(self) -> bool:
        return any(mark in self.report.keywords for mark in RACY)

    def reason(self) -> str:
        """Return the last line of the failure that says anything."""
        crash = getattr(self.report.longrepr, 'reprcrash', None)
        text = crash.message if crash else self.report.longreprtext
        lines = [line for line in text.splitlines() if line.strip()]
        return lines[0].strip()[:200] if lines else 'no text'


class Reruns:
    """Collects failures, runs the racy ones again at the end, and decides about the run."""

    def __init__(self, config):
        self._config = config
        self._failures: dict[str, Failure] = {}
        self._is_collected = True
        self._folder = Path(config.rootpath) / 'log/flaky'

    def pytest_collectreport(self, report):
        self._is_collected &= not report.failed

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self._failures.setdefault(report.nodeid, Failure(report))

    @pytest.hookimpl(wrapper=True, trylast=True)
    def pytest_sessionfinish(self, session):
        """Run after the workers have ended and before the terminal's summary."""
        result = yield
        racy = [failure for failure in self._failures.values() if failure.is_racy]
        if session.exitstatus == pytest.ExitCode.TESTS_FAILED and len(racy) <= MOST:
            for failure in racy:
                failure.passes_alone = self._passes_alone(failure)
            self._count_as_flaky()
            all_pass = all(failure.passes_alone for failure in self._failures.values())
            if all_pass and self._is_collected:
                session.exitstatus = pytest.ExitCode.OK
        return result

    def _passes_alone(self, failure: Failure) -> bool:
        """Run a test in a pytest of its own and keep both logs."""
        self._folder.mkdir(parents=True, exist_ok=True)
        log = self._folder / (re.sub(r'[^\w.-]+', '_', failure.nodeid)[-150:] + '.log')
        sections = [f'{title}\n{text}' for title, text in failure.report.sections]
        log.write_text('\n'.join([failure.report.longreprtext, *sections, '', 'Alone:', '']))
        options = [NO_RERUNS, '-p', 'no:cacheprovider', '-rA']
        if self._config.getoption('--everything'):
            options.append('--everything')
        command = [sys.executable, '-m', 'pytest', *options, failure.nodeid]
        with log.open('a') as output:
            try:
                code = subprocess.run(
                    command,
                    cwd=self._config.rootpath,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    timeout=PATIENCE,
                    check=False,
                ).returncode
            except subprocess.TimeoutExpired:
                return False
        return code == pytest.ExitCode.OK

    def _count_as_flaky(self):
        """Move the reports of tests that pass alone from the failed ones to the flaky ones."""
        terminal = self._config.pluginmanager.get_plugin('terminalreporter')
        for outcome in ('failed', 'error'):
            reports = terminal.stats.pop(outcome, [])
            for report in reports:
                # A file that could not be imported has a report, too.
                failure = self._failures.get(report.nodeid)
                is_flaky = failure is not None and failure.passes_alone
                terminal.stats.setdefault('flaky' if is_flaky else outcome, []).append(report)

    @pytest.hookimpl(trylast=True)
    def pytest_terminal_summary(self, terminalreporter):
        flaky = [failure for failure in self._failures.values() if failure.passes_alone]
        for failure in flaky:
            line = f'flaky: {failure.nodeid} (first failure: {failure.reason()})'
            terminalreporter.write_line(line, yellow=True)
        racy = sum(failure.is_racy for failure in self._failures.values())
        if racy > MOST:
            terminalreporter.write_line(
                f'{racy} tests of processes, topics or clocks failed; '
                f'more than {MOST} is no race: none was run again',
                red=True,
            )


def pytest_addoption(parser):
    parser.addoption(
        NO_RERUNS, action='store_true', help='run no test of processes, topics or clocks again'
    )


def pytest_configure(config):
    if not (config.getoption(NO_RERUNS) or hasattr(config, 'workerinput')):
        config.pluginmanager.register(Reruns(config), 'reruns')
