"""FindCollisionCandidates: kept ids, ids made anew, the array of their values, and pydrake's list.

    ./run exec python -m bench.costs.candidates [--scenes arms spheres-200 ...]

Scenes of ``bench.peers`` at robot speed; each cycle poses all bodies, and a side takes ten in
turn. Microseconds, median / mean / p99, and pydrake's time / that of kept ids: above 1 is faster.
"""

from __future__ import annotations

import argparse
from statistics import fmean, median

import numpy as np

from bench.peers import ours
from bench.peers.run import POSES
from bench.peers.scenes import FULL, build
from bench.peers.timing import Turn, interleave
from drake_geom_ros.geometry import GeometryId


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--scenes', nargs='+', choices=list(FULL), default=list(FULL))
    options = parser.parse_args()
    try:
        from bench.peers import drake_side
    except ImportError:
        drake_side = None  # type: ignore[assignment]
    for name in options.scenes:
        scene = build(name)
        poses = scene.motion.poses(POSES, 0, 'robot')
        sides = [ours.Side(scene) for _ in range(3)]
        kept, made, array = (side.query for side in sides)

        def ids_made_anew(query: object = made) -> int:
            ids_A, ids_B = query.collision_candidates().T.tolist()  # type: ignore[attr-defined]
            pairs = zip(ids_A, ids_B, strict=True)
            return len([(GeometryId(a), GeometryId(b)) for a, b in pairs])

        asks = {
            'kept ids': lambda query=kept: len(query.FindCollisionCandidates()),
            'made ids': ids_made_anew,
            'array': lambda query=array: len(query.collision_candidates()),
        }
        turns = {
            way: Turn(poses, side.set_poses, ask)
            for side, (way, ask) in zip(sides, asks.items(), strict=True)
        }
        if drake_side is not None:
            peer = drake_side.Side(scene)
            layouts = [peer.layout(X_WFs) for X_WFs in poses]
            turns['pydrake'] = Turn(layouts, peer.set_poses, peer.answers['candidates'])
        taken = interleave(turns, 1.0, dict.fromkeys(turns, 2.0))
        texts, times = [], {}
        for way, took in taken.items():
            times[way] = median(took.seconds)
            values = times[way], fmean(took.seconds), float(np.percentile(took.seconds, 99))
            texts.append(f'{way} ' + ' / '.join(f'{1e6 * value:.1f}' for value in values))
        if 'pydrake' in times:
            texts.append(f'{times["pydrake"] / times["kept ids"]:.2f}')
        print(f'{name:15}' + '; '.join(texts), flush=True)


if __name__ == '__main__':
    main()
