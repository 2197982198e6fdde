"""Answers about stops, against dense samples of random states of arms, a base and a person."""

import numpy as np
import pytest

from drake_geom_ros.stopping import RESOLUTION, Braking
from truth.judging.stops import StoppingCell

ROUNDING = 1e-9  # [m] of sampled distances
SHARES = np.array([0.25, 0.5, 0.8, 1.0])


def cell(category, *, with_base=False):
    braking = Braking(decelerations=(2.0,), reaction_time=0.1, category=category)
    return StoppingCell(braking, with_base=with_base)


@pytest.mark.parametrize('with_base', [False, True])
@pytest.mark.parametrize('category', [0, 1])
def test_no_stop_from_the_scale_or_slower_comes_too_near(category, with_base):
    it, rng, proved = cell(category, with_base=with_base), np.random.default_rng(7), 0
    for _ in range(60):
        moment = it.moment(rng)
        for number, stop in enumerate(it.stops(moment)):
            assert not stop.trouble
            proved += stop.scale > 0.0
            for share in SHARES * stop.scale if stop.scale else ():  # 0 promises nothing
                if category == 1:
                    went, seconds = it.along_path(moment, number, share)
                    left = it.worst(moment, number, went, seconds, 'no other arm')
                    assert left >= -ROUNDING
                went, seconds = it.by_itself(moment, number, share, rng)
                asked = 'the other arm' if category == 1 else None
                assert it.worst(moment, number, went, seconds, asked) >= -ROUNDING
    assert proved > 30


@pytest.mark.parametrize('with_base', [False, True])
def test_until_its_contact_time_the_stop_of_now_is_clear(with_base):
    it, rng, clear = cell(1, with_base=with_base), np.random.default_rng(3), 0
    for _ in range(120):
        moment = it.moment(rng)
        for number, stop in enumerate(it.stops(moment)):
            clear += stop.clear
            went, seconds = it.along_path(moment, number, 1.0)
            proved = seconds <= stop.contact_time
            if stop.contact_time > 0.0:
                left = it.worst(moment, number, went[proved], seconds[proved], 'no other arm')
                assert left >= -ROUNDING
    assert clear > 10


def test_a_scale_is_no_smaller_than_it_must_be():
    it, rng, judged = cell(1), np.random.default_rng(5), 0
    for _ in range(60):
        moment = it.moment(rng)
        for number, stop in enumerate(it.stops(moment)):
            pair = {it.names[id][0] for id in (stop.id_A, stop.id_B) if id}
            if not 0.0 < stop.scale < 1.0 - RESOLUTION or pair == {'left', 'right'}:
                continue
            judged += 1
            reached = []
            for share in np.linspace(stop.scale, stop.scale + 1.1 * RESOLUTION, 12):
                went, seconds = it.along_path(moment, number, share)
                reached.append(it.worst(moment, number, went[-1:], seconds[-1:], 'no other arm'))
            assert min(reached) < 2e-3
    assert judged > 10
