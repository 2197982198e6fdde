"""Maps where an arm's hand can be among obstacles, and how close it gets to them: a picture.

    python examples/reach_of_an_arm.py [--states 200000] [--out reach.png]

The left arm of the demo's cell is put into random postures. Each cell of the map, a slice through
the scene seen from the side, shows the largest clearance of the postures that bring the hand
there: white where no posture does, orange where all of them collide.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.geometry import CollisionFilterDeclaration, GeometrySet, SceneGraph
from drake_geom_ros.scene_files import load_scene

SCENE = Path(__file__).parents[1] / 'scenes/two_pandas.yaml'
CELL = 0.04  # [m] side of a cell of the map
BLOCK = 10_000  # states whose poses are in memory at once
HALF_WIDTH = 0.08  # [m] of the slice, either side of the arm's middle plane
# The right arm's joints meanwhile: it looks down at the table's middle [rad], fingers shut [m].
ASIDE = (0.0, -0.8, 0.0, -2.2, 0.0, 1.6, 0.8, 0.0)
LIMITS = ((-1.6, 0.4), (0.2, 1.8))  # [m] of the map, along x and z


def main() -> None:
    """Draw the map."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--states', type=int, default=200_000)
    parser.add_argument('--out', type=Path, default=Path('reach.png'))
    options = parser.parse_args()

    scene_graph = SceneGraph()
    loaded = load_scene(SCENE, scene_graph)
    # How close other things are to each other is not asked.
    others = [id for (source, _, _), id in loaded.geometries.items() if source != 'left']
    declaration = CollisionFilterDeclaration().ExcludeWithin(GeometrySet(others))
    scene_graph.collision_filter_manager().Apply(declaration)
    joints = Joints.of(loaded)  # of both arms, the left one first

    rng = np.random.default_rng(0)
    states = rng.uniform(joints.lower, joints.upper, (options.states, joints.count))
    states[:, joints.count // 2 :] = ASIDE
    hand = joints.frame_ids.index(loaded.frames['left', 'panda_hand'])
    p_WHs = np.empty((len(states), 3))
    for first in range(0, len(states), BLOCK):
        block = slice(first, first + BLOCK)
        p_WHs[block] = joints.poses(states[block])[:, hand, :3]
    inside = np.abs(p_WHs[:, 1]) < HALF_WIDTH
    clearances = evaluate(
        scene_graph, want='least', max_distance=1.0, states=states[inside], joints=joints
    ).distance

    edges = [np.arange(low, high + CELL, CELL) for low, high in LIMITS]
    columns, rows = (
        np.digitize(p_WHs[inside, axis], edge) - 1
        for axis, edge in zip((0, 2), edges, strict=True)
    )
    best = np.full((len(edges[1]), len(edges[0])), -np.inf)
    np.maximum.at(best, (rows, columns), clearances)
    reached = np.isfinite(best)
    free = reached & (best > 0.0)
    print(f'{inside.sum()} of {len(states)} postures have the hand in the slice')
    print(f'{reached.sum()} cells are reached, {free.sum()} without a collision')

    figure = Figure(figsize=(7.0, 5.5), layout='constrained')
    axes = figure.add_subplot()
    colours = np.where(free, best, np.nan)
    image = axes.pcolormesh(*edges, colours[:-1, :-1], cmap='viridis', vmin=0.0)
    axes.pcolormesh(
        *edges,
        np.where(reached & ~free, 1.0, np.nan)[:-1, :-1],
        cmap='Oranges',
        vmin=0.0,
        vmax=1.4,
    )
    figure.colorbar(image, label='largest clearance [m]')
    axes.set(xlabel='x [m]', ylabel='z [m]', aspect='equal')
    axes.set_title('where the left hand can be: orange cells only with a collision')
    figure.savefig(options.out, dpi=120)
    print(f'wrote {options.out}')


if __name__ == '__main__':
    main()
