"""Whether the tests notice a mutant: the tests that run its line, on code changed in memory.

Nothing on disk is mutated, so an interruption harms nothing. The tests run uncompiled
(``NUMBA_DISABLE_JIT=1``), for then the kernels are the Python that was mutated. They are collected
once; each mutant is tried in a process forked after that, where the code of the functions that
differ is put into the functions there are, so that it counts wherever they were imported to. What
a function does not hold (a module's constant, a default) takes a process that imports the mutated
module anew.
"""

from __future__ import annotations

import gc
import hashlib
import importlib
import inspect
import multiprocessing
import os
import random
import resource
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import pytest
from coverage import CoverageData

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = 'drake_geom_ros'
# Those whose tests say something of the files that are mutated, and run uncompiled.
TESTS = ('test/geometry', 'test/math', 'test/scene_files', 'test/effects')

# Of the processor: the longest test takes 16. How long a test waits, for its turn or for a process
# that it started, tells little on a busy machine, and counts only when it is long beyond doubt.
SECONDS_A_TEST = 100.0
SECONDS_OF_WAITING = 1800
MEMORY = 8 * 2**30  # [bytes] that a mutant may ask for

# What becomes of a mutant.
NOTICED, HUNG, SURVIVED = 'noticed', 'hung', 'survived'

# Only the plugins that are named: the others take half a second a process.
_ENVIRONMENT = {'PYTEST_DISABLE_PLUGIN_AUTOLOAD': '1'}

# Where a decorator keeps the function.
_PARTS = ('__func__', 'fget', '__wrapped__')

_OPTIONS = ('-q', '-p', 'no:cacheprovider', '-p', 'pytest_timeout')
_OPTIONS += (f'--timeout={SECONDS_OF_WAITING}',)


class _Clock:
    """Ends a process whose test takes too much of the processor."""

    def pytest_runtest_logstart(self) -> None:
        signal.setitimer(signal.ITIMER_PROF, SECONDS_A_TEST)


def measure(keep: Path) -> CoverageData:
    """Return which test runs which line; kept in a folder for as long as the package is the same.

    Raises RuntimeError where the tests fail without any mutant.
    """
    digest = hashlib.sha256()
    for path in sorted((ROOT / PACKAGE).rglob('*.py')):
        digest.update(path.read_bytes())
    kept = keep / f'lines-{digest.hexdigest()[:16]}'
    if not kept.exists():
        print('all tests under coverage, for which of them runs which line: some minutes')
        keep.mkdir(parents=True, exist_ok=True)
        fresh = kept.with_suffix('.new')
        command = [sys.executable, '-m', 'pytest', *_OPTIONS, *TESTS, '-p', 'pytest_cov']
        command += [f'--cov={PACKAGE}', '--cov-context=test', '--cov-report=']
        environment = {**os.environ, **_ENVIRONMENT, 'COVERAGE_FILE': str(fresh)}
        if subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode != 0:
            raise RuntimeError('the tests fail without any mutant')
        fresh.rename(kept)
    data = CoverageData(str(kept))
    data.read()
    return data


def tests_of(data: CoverageData, file: Path, line: int) -> set[str]:
    """Return the ids of the tests that run a line; for what runs on import, those of its file."""
    by_line = data.contexts_by_lineno(str(file))
    contexts = set(by_line.get(line, []))
    if '' in contexts:
        contexts = {context for each in by_line.values() for context in each}
    return {context.rpartition('|')[0] for context in contexts} - {''}


def mirrored(file: Path) -> tuple[str, str]:
    """Return what the ids of a file's own tests begin with: its path in ``test``, or more."""
    path = file.relative_to(ROOT).with_suffix('')
    name = str(Path('test', *path.parts[1:-1], f'test_{path.name.lstrip("_")}'))
    return f'{name}.py::', f'{name}_'


def with_tests_collected(work: Callable[[list[Any]], None]) -> None:
    """Call ``work`` with all tests, in a process that has collected them and has run none."""

    class _Instead:
        def pytest_runtestloop(self, session: Any) -> bool:
            gc.freeze()  # a fork that collects garbage would copy all there is
            work(session.items)
            return True

    os.environ |= _ENVIRONMENT
    os.chdir(ROOT)
    status = pytest.main([*_OPTIONS, *TESTS], plugins=[_Instead(), _Clock()])
    if status not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
        raise RuntimeError(f'pytest ended with {status!r}')


def end_of(file: Path, code: str, ids: set[str], items: list[Any], most: int) -> str:
    """Return what becomes of a mutant: a file of the package that holds other code.

    It is NOTICED if a test fails, HUNG if one takes too long, or else SURVIVED. The tests are
    those of the file's own name, which come first, and those of the given ids, at most so many of
    them.
    """
    try:
        mutated = _compiled(code, str(file))
    except SyntaxError:
        return NOTICED
    chosen = [item for item in items if item.nodeid.startswith(mirrored(file))]
    others = [item for item in items if item.nodeid in ids - {item.nodeid for item in chosen}]
    random.Random(0).shuffle(others)  # neighbours notice the same
    chosen += others[:most]
    if not chosen:
        return SURVIVED
    changed = _changed_functions(_module_of(file), mutated)
    if changed:
        return _end_of_process(_run_items, changed, chosen)
    nodes = [item.nodeid for item in chosen]
    return _end_of_process(_run_anew, str(file), code, nodes)


def _compiled(code: str, file: str) -> CodeType:
    """Return the code of a file, without this file's imports from the future."""
    return compile(code, file, 'exec', dont_inherit=True)


def _module_of(file: Path) -> ModuleType:
    """Return the module of a file of the package."""
    return importlib.import_module('.'.join(file.relative_to(ROOT).with_suffix('').parts))


def _changed_functions(
    module: ModuleType, mutated: CodeType
) -> list[tuple[FunctionType, CodeType]]:
    """Return the functions of a module whose code differs, each with its other code."""
    there = {(code.co_firstlineno, code.co_name): code for code in _codes_in(mutated)}
    found = []
    for function in _functions_in(module):
        code = function.__code__
        other = there.get((code.co_firstlineno, code.co_name), code)
        if code != other and code.co_freevars == other.co_freevars:
            found.append((function, other))
    return found


def _codes_in(code: CodeType) -> Iterator[CodeType]:
    """Yield the code of all functions of a module, or within a function."""
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant
            yield from _codes_in(constant)


def _functions_in(space: ModuleType | type) -> Iterator[FunctionType]:
    """Yield the functions that are defined in a module, those of its classes included."""
    name = space.__name__ if isinstance(space, ModuleType) else space.__module__
    for value in vars(space).values():
        for each in (value, *(getattr(value, part, None) for part in _PARTS)):
            if inspect.isfunction(each) and each.__module__ == name:
                yield each
        if inspect.isclass(value) and value.__module__ == name and value is not space:
            yield from _functions_in(value)


def _end_of_process(work: Callable[..., None], *arguments: Any) -> str:
    """Return how work in a forked process ends, which it ends itself, with 0 if all is well."""
    process = multiprocessing.get_context('fork').Process(target=_limited, args=(work, arguments))
    process.start()
    process.join()
    if process.exitcode == 0:
        return SURVIVED
    return HUNG if process.exitcode == -signal.SIGPROF else NOTICED


def _limited(work: Callable[..., None], arguments: tuple[Any, ...]) -> None:
    """Work without a word, and within limits."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    quiet = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(quiet, stream)
    try:
        work(*arguments)
    finally:
        os._exit(1)


def _run_items(changed: list[tuple[FunctionType, CodeType]], items: list[Any]) -> None:
    """Run collected tests with other code in some functions, up to the first that fails."""
    for function, code in changed:
        function.__code__ = code
    items[0].config.pluginmanager.unregister(name='terminalreporter')
    for item, following in zip(items, [*items[1:], None], strict=True):
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
        if item.session.testsfailed:
            os._exit(1)
    os._exit(0)


def _run_anew(file: str, code: str, nodes: list[str]) -> None:
    """Run tests in a process that imports a file with other code, up to the first that fails."""
    command = [sys.executable, '-m', 'bench.mutants.trials', file, *_OPTIONS, '-x', *nodes]
    done = subprocess.run(command, input=code, text=True, cwd=ROOT, check=False)
    if done.returncode == -signal.SIGPROF:
        os.kill(os.getpid(), signal.SIGPROF)
    os._exit(done.returncode)


def _main(file: str, arguments: list[str]) -> int:
    """Run pytest with the code on the standard input in place of that of a file."""
    code, get_code = sys.stdin.read(), SourceFileLoader.get_code

    def get(loader: SourceFileLoader, name: str) -> CodeType | None:
        if loader.get_filename(name) != file:
            return get_code(loader, name)
        return _compiled(code, file)

    SourceFileLoader.get_code = get  # type: ignore[method-assign]
    return int(pytest.main(arguments, plugins=[_Clock()]))


if __name__ == '__main__':
    sys.exit(_main(sys.argv[1], sys.argv[2:]))
