"""The order in which libraries are linked: LLVM drops what nobody calls yet."""

import pytest
from numba import config

if config.DISABLE_JIT:
    pytest.skip('nothing is linked', allow_module_level=True)

from drake_geom_ros.geometry._proximity.runtime import compiled

if compiled.numba_inside is None:
    pytest.skip('of the pinned version of Numba only', allow_module_level=True)

from drake_geom_ros.geometry._proximity.runtime.numba_inside.pipeline import _called_by, _Library


def library(*called):
    """Return a library of ours without code, that calls others."""
    made = _Library.__new__(_Library)
    made._linking_libraries = list(called)
    return made


def test_callers_come_before_all_that_they_call():
    """Seen as a crash: of two callers the first had lost its call, and the second came later."""
    slab = library()
    early, late = library(slab), library(slab)
    entry = library(slab, early, late)
    order = _called_by(entry)
    assert {id(each) for each in order} == {id(slab), id(early), id(late)}
    assert order.index(slab) == 2


def test_each_is_linked_once_however_many_call_it():
    shared = library()
    chain = shared
    for _ in range(30):  # 2^30 ways down
        chain = library(chain, chain)
    assert len(_called_by(chain)) == 30
