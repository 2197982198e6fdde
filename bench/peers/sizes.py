"""What size costs: 1000 to 100 000 balls, every pace, beside the libraries that can take them.

The room grows with the number, so that a body has as many neighbours in each scene.
"""

from __future__ import annotations

import gc
import os
from pathlib import Path

import matplotlib
from matplotlib import pyplot

from bench.pages import table
from bench.peers import ours, scenes
from bench.peers.chart import COLOURS, DPI
from bench.peers.motion import PACES
from bench.peers.run import installed
from bench.peers.timing import Taken, Turn, interleave
from bench.ros.processes import memory

matplotlib.use('Agg')

SIZES = (1000, 3000, 10_000, 30_000, 100_000)
POSES = 12  # until the motion is run backwards: of 100 000 balls one takes 5.6 MB
LIMIT = 2.0  # [s] a cycle, of peers
# The most balls that each is given: to build more takes some minutes, or too much memory.
MOST = {'ours': 100_000, 'MuJoCo': 10_000, 'python-fcl': 30_000, 'Coal': 30_000}
GROWTH = 45.0  # times the mean of 1000 balls that 30 000 may take
HEADINGS = ['balls', 'pace', 'library', 'mean [ms]', 'p99 [ms]', 'results', 'mean / that of 1000']


def _asked(scene: scenes.Scene, poses: scenes.Floats) -> ours.Side:
    """Return our side of a scene that has answered once."""
    side = ours.Side(scene)
    side.set_poses(poses)
    side.answers['penetration']()
    return side


class Growth:
    """Measures size after size and keeps what it measured."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._modules, missing = installed()
        self._means: dict[tuple[str, str], dict[int, float]] = {}  # by library and pace [s]
        self._rows: list[list[str]] = []
        self.lines = list(missing)

    def size(self, count: int) -> None:
        """Measure the penetrations of so many balls at each pace."""
        _asked(scenes.spheres(10), scenes.spheres(10).motion.poses(1, 0, 'jump')[0])  # compiled
        scene = scenes.spheres(count)
        first = scene.motion.poses(1, 0, 'jump')[0]
        gc.collect()
        before = memory(os.getpid())
        sides = {'ours': _asked(scene, first)}
        found = sides['ours'].answers['penetration']()
        effects = sides['ours'].query.effects()
        grown = 1e6 * (memory(os.getpid()) - before)
        self._say(
            f'{count} balls: {grown / count:.0f} bytes of memory a ball, with the '
            f'scene and an answer; {effects.broadphase_pairs / count:.1f} pairs a ball are '
            f'looked at, {found} overlap'
        )
        for module in self._modules:
            if module.NAME != 'ours' and count <= MOST.get(module.NAME, 0):
                sides[module.NAME] = module.Side(scene)
        for pace in PACES:
            poses = scene.motion.poses(POSES, 0, pace)
            turns = {
                name: Turn([side.layout(X) for X in poses], side.set_poses, answer)
                for name, side in sides.items()
                if (answer := side.answers.get('penetration'))
            }
            limits = {name: 60.0 if name == 'ours' else LIMIT for name in turns}
            self._note(count, pace, interleave(turns, self._seconds, limits))

    def _say(self, line: str) -> None:
        self.lines.append(line)
        print(line, flush=True)

    def _note(self, count: int, pace: str, taken: dict[str, Taken]) -> None:
        """Keep and print what a size and a pace took."""
        for name, one in taken.items():
            mean, worst = one.mean(), one.worst()
            if mean is None or worst is None:
                self._say(f'{count} balls, {pace}: {name} {one.left_out}')
                continue
            means = self._means.setdefault((name, pace), {})
            means[count] = mean
            times = f'{mean / means[1000]:.1f}' if 1000 in means else '-'
            found = one.mean_found() or 0.0
            cells = [f'{1e3 * mean:.3g}', f'{1e3 * worst:.3g}', f'{found:.0f}', times]
            self._rows.append([str(count), pace, name, *cells])
            print('  '.join(f'{cell:>10}' for cell in self._rows[-1]), flush=True)

    def verdicts(self) -> list[str]:
        """Return a line for each target of size."""
        lines = []
        for pace in PACES:
            ours_, mujoco = (
                self._means.get(('ours', pace), {}),
                self._means.get(('MuJoCo', pace), {}),
            )
            if {1000, 30_000} <= set(ours_):
                times = ours_[30_000] / ours_[1000]
                met = 'met' if times <= GROWTH else 'MISSED'
                lines.append(
                    f'{pace}: 30 000 balls take {times:.1f} times 1000; {GROWTH:g}: {met}'
                )
            if 10_000 in ours_ and 3000 in mujoco:
                a, b = 1e3 * ours_[10_000], 1e3 * mujoco[3000]
                lines.append(f'{pace}: 10 000 balls take {a:.2f} ms, MuJoCo {b:.2f} ms for 3000')
        return lines

    def write(self, folder: Path) -> None:
        """Print the verdicts; write sizes.md and sizes.png."""
        lines = [*self.lines, *self.verdicts()]
        print('\n'.join(self.verdicts()))
        text = '\n\n'.join(
            [
                '# What size costs',
                '\n'.join(f'- {line}' for line in lines),
                table(HEADINGS, self._rows, left=3),
            ]
        )
        (folder / 'sizes.md').write_text(text + '\n')
        self._draw(folder / 'sizes.png')
        print(f'written: {folder / "sizes.md"}, {folder / "sizes.png"}')

    def _draw(self, path: Path) -> None:
        """Write a PNG with a panel for each pace, both axes logarithmic."""
        figure, axes = pyplot.subplots(
            1, len(PACES), figsize=(10.0, 4.0), sharey=True, layout='constrained'
        )
        for panel, pace in zip(axes, PACES, strict=True):
            for (name, its_pace), means in self._means.items():
                if its_pace == pace:
                    times = [1e3 * seconds for seconds in means.values()]
                    panel.loglog(list(means), times, 'o-', color=COLOURS.get(name), label=name)
            panel.set_title(pace)
            panel.set_xlabel('balls')
            panel.grid(True, which='major', alpha=0.4)
        axes[0].set_ylabel('poses and penetrations, mean [ms]')
        axes[-1].legend(loc='lower right')
        figure.savefig(path, dpi=DPI)
        pyplot.close(figure)
