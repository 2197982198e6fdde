"""Use of Numba's internals, for the one version that ``compiled`` checks for.

With another version the package uses public interfaces alone: answers are the same, compiling
takes longer, references to arrays are counted (``test_pipeline``), and processes that need the
same function at the same time each compile it.
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
from drake_geom_ros.geometry._proximity.runtime.numba_inside.shared_cache import (
    WAITING,
    share_cache,
)

__all__ = [
    'WAITING',
    'address_of',
    'for_compiled_callers',
    'integers',
    'options',
    'outlive',
    'part',
    'row',
    'share_cache',
    'table',
    'taker',
    'wide_integers',
]
