"""The files that the cache of compiled code depends on, and a name for their content."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterable
from pathlib import Path

PACKAGE = Path(__file__).parents[3]
_PROXIMITY = PACKAGE / 'geometry/_proximity'
# All that is compiled in, as folders and files.
SOURCES = (_PROXIMITY, PACKAGE / 'math/tolerances.py')
# Plain Python among them: no compiled function uses a name of these files, so an edit leaves the
# cache as it is. A test derives the list from the syntax of the sources.
UNCOMPILED = frozenset(
    _PROXIMITY / name
    for name in (
        'effects.py',
        'engine/engine.py',
        'engine/prepared.py',
        'engine/waiting.py',
        'engine/warm_up.py',
        'filters/groups.py',
        'filters/log.py',
        'filters/state.py',
        'kernels/shapes/hull_packing.py',
        'kernels/solids/packing.py',
        'kernels/solids/pieces.py',
        'motion/joint_path.py',
        'motion/motion_loops.py',
        'motion/speeds.py',
        'motion/tree.py',
        'near/following.py',
        'pairs/budget.py',
        'pairs/budgeted.py',
        'pairs/level_costs.py',
        'points/sharing.py',
        'states/joint_loops.py',
        'states/state_loops.py',
        'world/columns.py',
        'world/kept_poses.py',
        'world/row_change.py',
        'world/world.py',
    )
)


def digest_of(sources: Iterable[Path], uncompiled: Collection[Path] = ()) -> str:
    """Return a name for the content of files, and of all sources in folders."""
    digest = hashlib.sha256()
    for source in sources:
        for path in sorted(source.rglob('*.py')) if source.is_dir() else [source]:
            if path not in uncompiled:
                digest.update(str(path.relative_to(source.parent)).encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
