"""Random robots: joints of all kinds, some on links of another robot or on a frame of a scene."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch import Checker, Joints
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene

Floats = NDArray[np.float64]
_KINDS = ('revolute', 'continuous', 'prismatic', 'mimic', 'planar', 'floating', 'fixed')


class RandomRobots:
    """Two or three robots among posts, a plate and, at times, a floor; ``paths`` start free."""

    def __init__(self, rng: np.random.Generator, mesh: str) -> None:
        folder = Path(tempfile.mkdtemp())
        robots = []
        for k in range(int(rng.integers(2, 4))):
            links = int(rng.integers(3, 6))
            (folder / f'r{k}.urdf').write_text(_urdf(rng, links, mesh))
            on = ['', 'cart', *(f'r{k - 1}::l{j}' for j in range(1, 3) if k)]
            carrier = on[rng.integers(len(on))]
            where = _place(rng, 0.6 if carrier else 1.5)
            mounted = f', mounted_on: "{carrier}"' if carrier else ''
            solid = ', solid_meshes: ["*"]' if rng.integers(2) else ''
            robots.append(
                f'  - {{name: r{k}, urdf: r{k}.urdf, pose: {{{where}}}{mounted}{solid}}}'
            )
        self.scene_graph = SceneGraph()
        scene = folder / 'scene.yaml'
        scene.write_text('\n'.join(('name: hunt', 'sources: [posts]', 'robots:', *robots, '')))
        with scene.open('a') as file:
            file.write(_posts(rng))
        self.joints = Joints.of(load_scene(scene, self.scene_graph))
        self._checker = Checker(self.scene_graph, self.joints)

    def paths(self, rng: np.random.Generator, count: int) -> Floats:
        """Return edges (n, 2, q), most of which start free, by steps of any size."""
        lower = self.joints.lower.clip(min=-3.0)
        upper = self.joints.upper.clip(max=3.0)
        states = rng.uniform(lower, upper, (8 * count, self.joints.count))
        free = self._checker.free_each(states)
        starts = np.concatenate((states[free], states[~free]))[:count]
        steps = 10 ** rng.uniform(-2.0, 0.5, (count, 1)) * rng.normal(size=starts.shape)
        steps[rng.integers(3, size=steps.shape) == 0] = 0.0  # some joints rest
        return np.stack((starts, starts + steps), axis=1)


def _place(rng: np.random.Generator, far: float) -> str:
    p, turns = rng.uniform(-far, far, 3).tolist(), rng.uniform(-3, 3, 3).tolist()
    return f'position: {p}, rpy: {turns}'


def _posts(rng: np.random.Generator) -> str:
    shapes = (
        'sphere, radius: 0.2',
        'box, size: [1.0, 1.0, 0.001]',
        'capsule, radius: 0.05, length: 1',
    )
    lines = [
        f'frames: [{{name: cart, source: posts, pose: {{{_place(rng, 1.0)}}}}}]',
        'geometries:',
    ]
    for k, shape in enumerate(shapes):
        where = f'pose: {{{_place(rng, 2.0)}}}'
        lines.append(f'  - {{name: p{k}, source: posts, {where}, shape: {{type: {shape}}}}}')
    if rng.integers(2):
        floor = 'pose: {position: [0, 0, -2.5]}, shape: {type: half_space}'
        lines.append(f'  - {{name: floor, source: posts, {floor}}}')
    return '\n'.join(lines) + '\n'


def _urdf(rng: np.random.Generator, links: int, mesh: str) -> str:
    """Return a robot whose links hang on any of those before them."""
    lines, led = ['<robot name="r">', '<link name="l0"/>'], 0
    for k in range(1, links):
        lines.append(f'<link name="l{k}">{_collision(rng, mesh)}</link>')
        kind, tail = str(rng.choice(_KINDS)), ''
        if kind == 'mimic' and not led:
            kind = 'revolute'
        if kind in ('revolute', 'prismatic', 'mimic'):
            tail = '<limit lower="-2" upper="2" velocity="1" effort="1"/>'
        if kind == 'mimic':
            factor, offset = rng.uniform(-2, 2, 2)
            tail += f'<mimic joint="j{led}" multiplier="{factor}" offset="{offset}"/>'
            kind = str(rng.choice(('revolute', 'prismatic')))
        elif kind in ('revolute', 'prismatic', 'continuous'):
            led = k
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        lines.append(
            f'<joint name="j{k}" type="{kind}"><parent link="l{int(rng.integers(k))}"/>'
            f'<child link="l{k}"/><origin xyz="{_text(rng.uniform(-0.6, 0.6, 3))}" '
            f'rpy="{_text(rng.uniform(-3, 3, 3))}"/><axis xyz="{_text(axis)}"/>{tail}</joint>'
        )
    return '\n'.join([*lines, '</robot>'])


def _collision(rng: np.random.Generator, mesh: str) -> str:
    shapes: tuple[Any, ...] = (
        f'<sphere radius="{rng.uniform(0.03, 0.2)}"/>',
        f'<box size="{_text(rng.uniform(0.02, 0.5, 3))}"/>',
        f'<cylinder radius="{rng.uniform(0.02, 0.1)}" length="{rng.uniform(0.1, 0.8)}"/>',
        f'<mesh filename="{mesh}" scale="0.4 0.4 0.4"/>',
    )
    origin = f'<origin xyz="{_text(rng.uniform(-0.3, 0.3, 3))}" rpy="0.3 0 1"/>'
    return f'<collision>{origin}<geometry>{rng.choice(shapes)}</geometry></collision>'


def _text(numbers: Floats) -> str:
    return ' '.join(f'{x:.17g}' for x in numbers)
