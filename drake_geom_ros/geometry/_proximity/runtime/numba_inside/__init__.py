"""Use of Numba's internals, for the one version that ``compiled`` checks for.

With another version the package uses public interfaces alone: answers are the same, compiling
takes longer, and references to arrays are counted (``test_pipeline``).
"""

from drake_geom_ros.geometry._proximity.runtime.numba_inside.array_views import (
    integers,
    outlive,
    part,
    row,
    table,
    taker,
    wide_integers,
)
from drake_geom_ros.geometry._proximity.runtime.numba_inside.pipeline import (
    address_of,
    for_compiled_callers,
    options,
)

__all__ = [
    'address_of',
    'for_compiled_callers',
    'integers',
    'options',
    'outlive',
    'part',
    'row',
    'table',
    'taker',
    'wide_integers',
]
