"""The hunt for wrong motions passes right answers and sees each kind of wrong one."""

from dataclasses import replace

import pytest

from bench.motion import hunt
from drake_geom_ros.geometry.queries.motion_queries import MotionQueries


def all_clear(found, asked):
    """Return what was found of a motion as if it were clear, however near its bodies come."""
    if found.outcome != 'contact':
        return found
    bound = 1.001 * asked.min_distance or 1e-9
    return replace(found, outcome='clear', times=(1.0, 1.0), lower_bound=bound)


def later(found, asked):
    return replace(found, times=tuple(min(t + 0.05, 1.0) for t in found.times))


def earlier(found, asked):
    return replace(found, times=tuple(max(t - 0.01, 0.0) for t in found.times))


def wider(found, asked):
    return replace(found, lower_bound=2.0 * found.lower_bound)


def test_the_hunt_finds_nothing_wrong(capsys):
    assert hunt.run(300, 7) == 0
    assert '300 motions' in capsys.readouterr().out


@pytest.mark.parametrize('lie', [all_clear, later, earlier, wider])
def test_the_hunt_sees_each_kind_of_lie(monkeypatch, lie):
    for name in ('move', 'follow'):
        honest = getattr(MotionQueries, name)

        def lying(self, asked, *given, _honest=honest, **more):
            return lie(_honest(self, asked, *given, **more), asked)

        monkeypatch.setattr(MotionQueries, name, lying)
    assert hunt.run(300, 7) == 1
