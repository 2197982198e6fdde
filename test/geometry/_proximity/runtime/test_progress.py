"""Who waits for what is compiled is told on standard error, unless somebody else tells it."""

from types import SimpleNamespace as Plain

import pytest

from drake_geom_ros.geometry._proximity.runtime import progress
from drake_geom_ros.geometry._proximity.runtime.progress import Progress


def event_of(name, module='drake_geom_ros.geometry._proximity.engine.pair_query'):
    function = Plain(__name__=name, __module__=module)
    return Plain(data={'dispatcher': Plain(py_func=function)})


@pytest.fixture
def told(monkeypatch, capsys):
    """Return what is said of functions compiled inside each other, from the first moment on."""
    monkeypatch.setattr(progress, '_SOON', 0.0)

    def told(*names, folder='/cache', silent=False):
        listener = Progress(folder)
        events = [event_of(name) for name in names]

        def compile_all():
            for each in events:
                listener.on_start(each)
            for each in reversed(events):
                listener.on_end(each)

        if silent:
            with listener.silent():
                compile_all()
        else:
            compile_all()
        return capsys.readouterr()

    return told


def test_one_line_says_what_how_far_and_where_it_is_kept(told):
    out, errors = told('run_cycle', '_answer', 'dot')
    assert out == ''
    (line,) = errors.splitlines()
    assert line == (
        'drake_geom_ros: compiling, once: run_cycle, 1 functions so far, 0 s; kept in /cache'
    )


def test_without_a_cache_it_says_that_it_is_for_this_process_only(told):
    assert 'for this process only' in told('run_cycle', folder='').err


def test_who_is_told_otherwise_reads_no_line(told):
    assert told('run_cycle', silent=True).err == ''


def test_what_takes_no_time_is_not_told(capsys):
    listener = Progress('/cache')
    listener.on_start(event_of('dot'))
    listener.on_end(event_of('dot'))
    assert capsys.readouterr().err == ''


def test_a_line_comes_again_after_ten_seconds(told, monkeypatch):
    clock = iter(range(0, 1000, 6))
    monkeypatch.setattr(progress.time, 'monotonic', lambda: float(next(clock)))
    lines = told('run_cycle', 'a', 'b', 'c', 'd').err.splitlines()
    assert 2 <= len(lines) <= 4
    assert 'functions so far' in lines[-1]
