"""Films a motion of two arms, with the nearest points between them: an animated picture.

    python examples/film_a_motion.py [--frames 120] [--width 720] [--out two_arms.gif]

The motion is that of the demo. Each picture shows the shortest line from one arm to the other, and
its length. The pictures are rendered by the package itself; pillow writes the file.
"""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FramePoseVector,
    GeometrySet,
    QueryObject,
    SceneGraph,
)
from drake_geom_ros.scene_files import load_scene, read_scene
from drake_geom_ros.trajectories import load_motion
from drake_geom_ros.viewing.notebook import show

SCENE = Path(__file__).parents[1] / 'scenes/two_pandas.yaml'
MOTION = SCENE.with_name('two_pandas_motion.yaml')
CAMERA = {'from_W': [1.0, -1.9, 1.3], 'at_W': [0.0, 0.0, 0.62], 'fov_y': 0.6}
COLOURS = 256  # of the palette: fewer make a smaller file


def main() -> None:
    """Write the film."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--frames', type=int, default=120)
    parser.add_argument('--width', type=int, default=800)
    parser.add_argument('--out', type=Path, default=Path('two_arms.gif'))
    options = parser.parse_args()

    scene_graph = SceneGraph()
    loaded = load_scene(SCENE, scene_graph)
    # Of all pairs only those of one arm and the other are asked about.
    arms = [
        GeometrySet([id for (source, _, _), id in loaded.geometries.items() if source == arm])
        for arm in ('left', 'right')
    ]
    declaration = CollisionFilterDeclaration().ExcludeWithin(
        GeometrySet(list(loaded.geometries.values()))
    )
    scene_graph.collision_filter_manager().Apply(declaration.AllowBetween(*arms))

    motion = load_motion(MOTION, read_scene(SCENE))
    frames = [
        loaded.frames[source, frame] for source, own in motion.frame_names.items() for frame in own
    ]
    context = scene_graph.CreateDefaultContext()
    pictures, distances = [], []
    for time in np.linspace(0.0, motion.duration, options.frames, endpoint=False):
        poses = np.concatenate(list(motion.poses(time).values()))
        context.UpdateFramePoses(FramePoseVector.FromArrays(frames, poses))
        query_object = scene_graph.get_query_output_port().Eval(context)
        distances.append(least_distance(query_object))
        size = options.width, 9 * options.width // 16
        shown = show(
            query_object, max_distance=np.inf, nearest=1, see_through=1.0, size=size, **CAMERA
        )
        pictures.append(Image.fromarray(shown.pixels))
    print(f'{len(pictures)} pictures; the arms are at least {min(distances):.4f} m apart')

    # One palette for all pictures, so that what stands still stays the same to the bit.
    palette = pictures[int(np.argmin(distances))].quantize(COLOURS, Image.Quantize.MAXCOVERAGE)
    first, *others = [
        each.quantize(palette=palette, dither=Image.Dither.NONE) for each in pictures
    ]
    period = round(1e3 * motion.duration / options.frames)
    first.save(options.out, save_all=True, append_images=others, duration=period, loop=0)
    print(f'wrote {options.out}')


def least_distance(query_object: QueryObject) -> float:
    """Return the certified lower bound of the distance [m] of the nearest pair."""
    pairs = query_object.ComputeSignedDistancePairwiseClosestPoints()
    return float((pairs.distance - pairs.error_bound).min())


if __name__ == '__main__':
    main()
