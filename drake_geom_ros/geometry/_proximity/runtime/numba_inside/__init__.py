"""All that relies on the inside of Numba, of the one version that ``compiled`` asks for it.

With another one everything does without, by public ways alone: answers are the same, compiling
takes longer, and references to arrays are counted (``test_pipeline``).

In: functions, and the arrays that compiled code looks at.
Out: options and callers of compiled functions, their addresses, and views of arrays.
May import: nothing of ours; numpy, numba, llvmlite.
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
