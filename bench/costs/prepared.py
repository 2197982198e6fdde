"""One cycle each 10 ms: a prepared call, a query object, and MuJoCo, in turns.

    ./run exec python -m bench.costs.prepared [--cycles 200] [--scenes arms spheres-50 ...]

The scenes and paces are those of ``bench.peers`` (`100 Hz`): poses of all bodies in, penetrations
out, all arrays read. Ratios are MuJoCo's time / ours: above 1 is faster. Without MuJoCo only our
two ways are printed.
"""

from __future__ import annotations

import argparse
import importlib
from statistics import fmean, median
from typing import Any

import numpy as np

from bench.peers import ours
from bench.peers.run import PAUSE, POSES
from bench.peers.scenes import FULL, Floats, Scene, build
from bench.peers.timing import Turn, interleave

LIMIT = 1.0  # [s] a cycle


class PreparedSide(ours.Side):
    """Our side by a prepared call, which takes the poses with the query."""

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self._call = self._context.prepare(self._frames, 'penetrations')
        self._poses: Floats = np.zeros((0, 7))

    def set_poses(self, poses: Floats) -> None:
        """Note the poses for the query."""
        self._poses = poses

    def penetration(self) -> int:
        """Pose all bodies, and read all arrays of the answer."""
        pairs: Any = self._call(self._poses)
        arrays = pairs.id_A, pairs.id_B, pairs.depth, pairs.p_WCa, pairs.p_WCb, pairs.nhat_BA_W
        return len(arrays[0])


def turns_of(scene: Scene) -> dict[str, Turn]:
    """Return the turn of each way to answer a scene."""
    poses = scene.motion.poses(POSES, 0, 'robot')
    prepared, usual = PreparedSide(scene), ours.Side(scene)
    turns = {
        'prepared': Turn(poses, prepared.set_poses, prepared.penetration),
        'query object': Turn(poses, usual.set_poses, usual.answers['penetration']),
    }
    try:
        mujoco = importlib.import_module('bench.peers.mujoco_side').Side(scene)
    except ImportError:
        return turns
    layouts = [mujoco.layout(X_WFs) for X_WFs in poses]
    return turns | {'MuJoCo': Turn(layouts, mujoco.set_poses, mujoco.answers['penetration'])}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--cycles', type=int, default=200)
    parser.add_argument('--scenes', nargs='+', choices=list(FULL), default=list(FULL))
    options = parser.parse_args()
    print("microseconds of a cycle after 10 ms of sleep: median / mean / p99; MuJoCo's / ours")
    for name in options.scenes:
        turns = turns_of(build(name))
        taken = interleave(
            turns, options.cycles * PAUSE * len(turns), dict.fromkeys(turns, LIMIT), pause=PAUSE
        )
        texts, times = [], {}
        for way, took in taken.items():
            times[way] = median(took.seconds)
            values = times[way], fmean(took.seconds), float(np.percentile(took.seconds, 99))
            texts.append(f'{way} ' + ' / '.join(f'{1e6 * value:.0f}' for value in values))
        if 'MuJoCo' in times:
            ratios = (times['MuJoCo'] / times[way] for way in ('prepared', 'query object'))
            texts.append('{:.2f} prepared, {:.2f} by a query object'.format(*ratios))
        print(f'{name:15}' + '; '.join(texts), flush=True)


if __name__ == '__main__':
    main()
