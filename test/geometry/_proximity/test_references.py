"""Arrays in compiled code: who counts references to them, and that none is lost or freed twice.

``compiled`` functions count none, ``allocating`` ones do. An array that is handed out by one kind
and taken by the other, in a record too, would be lost, or freed while it is in use.
"""

import ast
import importlib
import inspect
import pkgutil
import textwrap
import typing

import numpy as np
import pytest
from numba import config, njit
from numba.core.dispatcher import Dispatcher
from numba.core.runtime import _nrt_python, rtsys
from oracles.forms import kernel_form
from oracles.solids import solid

from drake_geom_ros.geometry import _proximity
from drake_geom_ros.geometry._proximity.kernels.calling.extremes import (
    SIGNATURE_BY_ADDRESS,
    call_by_address,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    NORMAL,
    PAIR_WIDTH,
    Aim,
    OrientedShape,
    call_kernel,
    compiled_address,
)
from drake_geom_ros.geometry._proximity.kernels.cores.sums import difference_of
from drake_geom_ros.geometry._proximity.kernels.pair_table import (
    ALL_ROWS,
    OVER_MAP_KERNEL,
    SHAPE_NAMES,
    load_kernel,
)
from drake_geom_ros.geometry._proximity.kernels.sensed.packing import map_parameters
from drake_geom_ros.geometry._proximity.kernels.solids.leaves import leaf_pair
from drake_geom_ros.geometry._proximity.kernels.solids.solid import body_of
from drake_geom_ros.geometry._proximity.kernels.trees.walks import walk
from drake_geom_ros.geometry._proximity.kinds import CONVEX, OCCUPIED_CELLS, SOLID
from truth.bodies.random_bodies import random_directions, random_rotation

VIEWS = {'row', 'part'}  # of ``kernels.calling.views``
NUMPY_MAKERS = {'empty', 'zeros', 'full', 'eye', 'copy', 'argsort'}


def _compiled_functions():
    """Return every compiled function of the package with its source, by the function."""
    found = {}
    for module in pkgutil.walk_packages(_proximity.__path__, f'{_proximity.__name__}.'):
        for each in vars(importlib.import_module(module.name)).values():
            if isinstance(each, Dispatcher) and each.py_func.__module__ == module.name:
                source = textwrap.dedent(inspect.getsource(each.py_func))
                found[each] = ast.parse(source).body[0]
    return found


def _holds_array(record):
    """Tell whether a class is a record with an array in it."""
    if not (isinstance(record, type) and hasattr(record, '_fields')):
        return False
    kinds = typing.get_type_hints(record).values()
    return any(typing.get_origin(kind) is np.ndarray or _holds_array(kind) for kind in kinds)


def _called(function, name):
    return function.py_func.__globals__.get(name)


def _makes(value, function, makers, known):
    """Tell whether an expression in a function is an array, or holds one."""
    if isinstance(value, ast.Tuple):
        return any(_makes(each, function, makers, known) for each in value.elts)
    if isinstance(value, ast.IfExp):
        return any(_makes(each, function, makers, known) for each in (value.body, value.orelse))
    if isinstance(value, ast.Name):
        return value.id in known
    if isinstance(value, ast.Call) and isinstance(value.func, ast.Attribute):
        return value.func.attr in NUMPY_MAKERS
    if isinstance(value, ast.Call):
        called = _called(function, value.func.id)
        return called in makers or _holds_array(called) or value.func.id in VIEWS
    return False


def _returns_array(function, tree, makers):
    known = {
        target.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Assign) and _makes(node.value, function, makers, set())
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    returned = [node.value for node in ast.walk(tree) if isinstance(node, ast.Return)]
    return any(_makes(value, function, makers, known) for value in returned)


@pytest.mark.skipif(config.DISABLE_JIT, reason='uncompiled, Python counts')
def test_who_returns_an_array_counts_as_its_callers_do():
    trees, makers, more = _compiled_functions(), set(), True
    while more:
        more = {f for f, tree in trees.items() if _returns_array(f, tree, makers)} - makers
        makers |= more
    assert {difference_of, body_of, walk, leaf_pair} <= makers
    wrong = []
    for function, tree in trees.items():
        names = {
            getattr(node.func, 'id', '') for node in ast.walk(tree) if isinstance(node, ast.Call)
        }
        for called in {_called(function, name) for name in names} & makers:
            if called.targetoptions['_nrt'] != function.targetoptions['_nrt']:
                wrong.append(
                    f'{function.py_func.__qualname__} calls {called.py_func.__qualname__}'
                )
    assert not wrong, '\n'.join(sorted(wrong))


@njit
def _call_each(address, kind_A, shape_A, R_WAs, kind_B, shape_B, R_WBs, p_AB_Ws, rows):
    """Call a kernel with slices that do have references, unlike those of the narrow phase."""
    for k in range(len(rows)):
        A = OrientedShape(kind_A, shape_A, R_WAs[k])
        B = OrientedShape(kind_B, shape_B, R_WBs[k])
        call_kernel(address, A, B, p_AB_Ws[k], Aim(1.0, 1e-9, np.inf, 0.0), rows[k])


@njit
def _call_each_over(by, address, kind_A, shape_A, R_WAs, kind_B, shape_B, R_WBs, p_AB_Ws, rows):
    """Call what takes a kernel over the cells of maps likewise."""
    for k in range(len(rows)):
        A = OrientedShape(kind_A, shape_A, R_WAs[k])
        B = OrientedShape(kind_B, shape_B, R_WBs[k])
        call_by_address(by, address, A, B, p_AB_Ws[k], Aim(1.0, 1e-9, np.inf, 0.0), rows[k])


def _shape(rng, kind):
    if kind >= OCCUPIED_CELLS:
        return map_parameters(0.1 * random_directions(rng, 20), 0.02)
    if kind == SOLID:
        return kernel_form(solid('L', 0.1))[1].copy()
    if kind == CONVEX:
        vertices = 0.1 * random_directions(rng, 12)
        return np.append(12.0, vertices)
    return rng.uniform(0.05, 0.1, 3)


@pytest.fixture
def statistics():
    """Count what is allocated and freed."""
    _nrt_python.memsys_enable_stats()
    yield rtsys.get_allocation_stats
    _nrt_python.memsys_disable_stats()


@pytest.mark.skipif(config.DISABLE_JIT, reason='uncompiled, Python counts')
@pytest.mark.parametrize(
    'row', ALL_ROWS, ids=lambda row: f'{SHAPE_NAMES[row.type_a]}-{SHAPE_NAMES[row.type_b]}'
)
def test_kernels_lose_no_array_and_free_none_twice(statistics, row):
    rng, count = np.random.default_rng(1), 60
    address = compiled_address(row.load_kernel())
    bodies = [
        (kind, _shape(rng, kind), np.array([random_rotation(rng) for _ in range(count)]))
        for kind in (row.type_a, row.type_b)
    ]
    # Deep, touching and apart; the first half without a hint.
    away = random_directions(rng, count) * rng.choice([0.0, 0.05, 0.12, 0.2, 1.0], (count, 1))
    rows = np.zeros((count, PAIR_WIDTH))
    rows[count // 2 :, NORMAL : NORMAL + 3] = random_directions(rng, count - count // 2)
    call, by = _call_each, ()
    if row.is_of_map:
        call = _call_each_over
        by = (compiled_address(load_kernel(OVER_MAP_KERNEL), SIGNATURE_BY_ADDRESS),)
    call(*by, address, *bodies[0], *bodies[1], away, rows)
    before = statistics()
    call(*by, address, *bodies[0], *bodies[1], away, rows)
    after = statistics()
    assert after.alloc - before.alloc == after.free - before.free
    assert after.mi_alloc - before.mi_alloc == after.mi_free - before.mi_free
    assert np.isfinite(rows).all()
