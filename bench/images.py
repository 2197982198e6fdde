"""Time of colour, depth and label images, ours beside pydrake's RenderEngineVtk where it is there.

    ./run exec python bench/images.py [--rounds 9] [--output out/images.json]

Two arms and a table at 640 x 480 by both, one script under both imports, and how their images
differ; then ours over pixels, primitives and triangles. Medians of milliseconds of processor time,
that of the threads of pydrake's driver included, and beside them of wall time: figures of one run
compare with one another. Memory is the largest resident set so far.
"""

import argparse
import importlib
import importlib.util
import json
import resource
import statistics
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.evidence import arms
from drake_geom_ros.evidence.bodies import Body

WIDTH, HEIGHT, FOV_Y = 640, 480, 0.8
NEAR, FAR = 0.05, 20.0
FROM, AT = np.array([1.6, -1.4, 1.2]), np.array([0.0, 0.0, 0.3])
# Farther from one another than this, depths are of different surfaces: beside a silhouette.
OTHER_SURFACE = 0.02  # [m]
# Nearer than this, they are of faces that lie in each other, and either label is right.
SAME_DEPTH = 1e-5  # [m]


class Library(NamedTuple):
    """The modules of one import, and how its renderer is made."""

    geometry: Any
    math: Any
    sensors: Any
    renderer: Callable[[Any], Any]


def ours() -> Library:
    """Return what this package has."""
    names = ('geometry', 'math', 'sensors')
    modules = (importlib.import_module(f'drake_geom_ros.{name}') for name in names)
    return Library(*modules, lambda geometry: geometry.MakeRenderEngineExact())


def pydrakes() -> Library | None:
    """Return what pydrake has, None where it is not installed."""
    if importlib.util.find_spec('pydrake') is None:
        return None
    names = ('geometry', 'math', 'systems.sensors')
    modules = (importlib.import_module(f'pydrake.{name}') for name in names)

    def make(geometry: Any) -> Any:
        return geometry.MakeRenderEngineVtk(geometry.RenderEngineVtkParams())

    return Library(*modules, make)


def shape_of(library: Library, body: Body) -> Any:
    """Return the shape of a body of the evidence."""
    return getattr(library.geometry, body.kind)(*body.size)


def pose(library: Library, p: Any, R: Any = None) -> Any:
    """Return a pose of a library."""
    rotation = np.eye(3) if R is None else R
    return library.math.RigidTransform(library.math.RotationMatrix(rotation), p)


def arms_and_table(library: Library) -> list[tuple[Any, Any]]:
    """Return shapes and poses of two arms over a table with boxes."""
    from scipy.spatial.transform import Rotation

    found = [
        (shape_of(library, body), pose(library, body.p, body.R))
        for body in arms.table(np.random.default_rng(0))
    ]
    poses = arms.link_poses(arms.BENT[None])[0]
    for body, X in zip(arms.links(), poses, strict=True):
        R = Rotation.from_quat(X[3:]).as_matrix()
        found.append((shape_of(library, body), pose(library, X[:3], R)))
    return found


def query_of(library: Library, bodies: list[tuple[Any, Any]]) -> Any:
    """Return a query object of a scene of anchored bodies, labelled by their places."""
    geometry = library.geometry
    scene = geometry.SceneGraph()
    source = scene.RegisterSource('bench')
    scene.AddRenderer('bench', library.renderer(geometry))
    for index, (shape, X) in enumerate(bodies):
        instance = geometry.GeometryInstance(X, shape, f'{index}')
        properties = geometry.PerceptionProperties()
        properties.AddProperty('label', 'id', geometry.RenderLabel(index % 30_000))
        instance.set_perception_properties(properties)
        scene.RegisterAnchoredGeometry(source, instance)
    context = scene.CreateDefaultContext()
    return scene.get_query_output_port().Eval(context), scene, context


def cameras(library: Library, width: int = WIDTH, height: int = HEIGHT) -> tuple[Any, Any]:
    """Return a colour and a depth camera."""
    geometry = library.geometry
    intrinsics = library.sensors.CameraInfo(width, height, FOV_Y)
    clipping = geometry.ClippingRange(NEAR / 2.0, 2.0 * FAR)
    core = geometry.RenderCameraCore('bench', intrinsics, clipping, pose(library, np.zeros(3)))
    depth_range = geometry.DepthRange(NEAR, FAR)
    return geometry.ColorRenderCamera(core), geometry.DepthRenderCamera(core, depth_range)


def looking(library: Library) -> Any:
    """Return X_WC of a camera that sees the table."""
    ahead = (AT - FROM) / np.linalg.norm(AT - FROM)
    aside = np.cross(ahead, [0.0, 0.0, 1.0])
    aside /= np.linalg.norm(aside)
    return pose(library, FROM, np.column_stack((aside, np.cross(ahead, aside), ahead)))


def three_calls(library: Library, query: Any, seen: tuple[Any, Any]) -> tuple[Any, Any, Any]:
    """Return colour, depth and label by pydrake's three queries."""
    W, X = library.geometry.SceneGraph.world_frame_id(), looking(library)
    colour, depth = seen
    return (
        query.RenderColorImage(colour, W, X),
        query.RenderDepthImage(depth, W, X),
        query.RenderLabelImage(colour, W, X),
    )


def milliseconds(task: Callable[[], Any], rounds: int) -> tuple[float, float]:
    """Return the medians of processor and wall time [ms]; the first call is not counted."""
    task()
    spent = []
    for _ in range(rounds):
        used, wall = time.process_time(), time.perf_counter()
        task()
        spent.append((time.process_time() - used, time.perf_counter() - wall))
    return tuple(1e3 * statistics.median(column) for column in zip(*spent, strict=True))


def balls(library: Library, count: int) -> list[tuple[Any, Any]]:
    """Return primitives of all kinds, as many in a room of one size: the more, the smaller."""
    random, geometry = np.random.default_rng(1), library.geometry
    size = 0.6 / count ** (1.0 / 3.0)
    made = []
    for k in range(count):
        a, b, c = size * random.uniform(0.2, 0.6, 3)
        shape = (
            *(geometry.Sphere(a), geometry.Box(a, b, c), geometry.Capsule(a / 2, b)),
            *(geometry.Cylinder(a / 2, b), geometry.Ellipsoid(a / 2, b / 2, c / 2)),
        )[k % 5]
        made.append((shape, pose(library, random.uniform([-1, -1, 0], [1, 1, 1]))))
    return made


def mesh(library: Library, count: int) -> list[tuple[Any, Any]]:
    """Return one wavy surface of about so many triangles."""
    n = max(int(np.sqrt(count / 2)), 1)
    x, y = np.meshgrid(*[np.linspace(-0.8, 0.8, n + 1)] * 2, indexing='ij')
    points = np.column_stack((x.ravel(), y.ravel(), 0.1 * np.sin(9 * x * y).ravel()))
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    first = np.column_stack((corner, corner + n + 1, corner + n + 2))
    second = np.column_stack((corner, corner + n + 2, corner + 1))
    data = library.geometry.MeshData(points, np.concatenate((first, second)))
    shape = library.geometry.Mesh.FromMeshData(data)
    return [(shape, pose(library, [0.0, 0.0, 0.3]))]


def together(
    library: Library, bodies: list[Any], rounds: int, size: tuple[int, int] = (WIDTH, HEIGHT)
) -> float:
    """Return the processor time [ms] of our three images in one pass."""
    query, *_ = query_of(library, bodies)
    _, camera = cameras(library, *size)
    W, X = library.geometry.SceneGraph.world_frame_id(), looking(library)
    return milliseconds(lambda: query.render_images(camera, W, X), rounds)[0]


def compared(a: tuple[Any, Any, Any], b: tuple[Any, Any, Any]) -> dict[str, float]:
    """Return how the images of ours and of pydrake differ."""
    mine, other = a[2].data[..., 0], b[2].data[..., 0]
    labels = mine == other
    beside = np.zeros_like(labels)  # a silhouette, in either image
    for image in (mine, other):
        for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
            beside |= np.roll(image, step, axis) != image
    depths = a[1].data[..., 0], b[1].data[..., 0]
    both = np.isfinite(depths[0]) & np.isfinite(depths[1])
    gaps = np.full(labels.shape, np.inf)
    gaps[both] = np.abs(depths[0] - depths[1])[both]
    same = gaps <= SAME_DEPTH
    inside = gaps[labels & (gaps < OTHER_SURFACE)]
    return {
        'pixels_of_other_label': int((~labels).sum()),
        'of_these_of_one_depth': int((~labels & same).sum()),
        'of_the_rest_away_from_silhouettes': int((~labels & ~same & ~beside).sum()),
        'median_depth_difference_m': float(np.median(inside)),
        'largest_depth_difference_m': float(inside.max()),
    }


def main() -> None:
    """Measure and print, and write a file where one is named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--rounds', type=int, default=9)
    parser.add_argument('--output', help='JSON file')
    parser.add_argument('--compare', action='store_true', help='only how images differ')
    options = parser.parse_args()
    found = difference() if options.compare else measured(options.rounds)
    for name, value in found.items():
        print(f'{name:32}', json.dumps(value))
    if options.output:
        Path(options.output).parent.mkdir(parents=True, exist_ok=True)
        Path(options.output).write_text(json.dumps(found, indent=1))


def difference() -> dict[str, Any]:
    """Return how images of ours and of pydrake differ; nothing where it is not installed."""
    made = []
    for library in filter(None, (ours(), pydrakes())):
        query, *kept = query_of(library, arms_and_table(library))
        made.append(three_calls(library, query, cameras(library)))
        del kept
    return compared(*made) if len(made) > 1 else {}


def measured(rounds: int) -> dict[str, Any]:
    """Return times [ms], by what was drawn."""
    found: dict[str, Any] = {}
    for name, library in (('ours', ours()), ('pydrake', pydrakes())):
        if library is None:
            print('pydrake is not installed: pip install drake')
            continue
        query, *kept = query_of(library, arms_and_table(library))
        seen = cameras(library)
        task = partial(three_calls, library, query, seen)
        found[f'{name}, three calls: used, wall'] = milliseconds(task, rounds)
        del kept
    mine = ours()
    found['ours, one pass'] = together(mine, arms_and_table(mine), rounds)
    found['difference'] = difference()
    for width in (160, 320, 640, 1280, 2560):
        size = width, width * 3 // 4
        found[f'{size[0]} x {size[1]}'] = together(mine, arms_and_table(mine), 3, size)
    for count in (10, 100, 1000, 10_000):
        found[f'{count} primitives'] = together(mine, balls(mine, count), 3)
    for count in (1000, 10_000, 100_000, 1_000_000):
        found[f'{count} triangles'] = together(mine, mesh(mine, count), 3)
    found['largest resident set [MB]'] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    return found


if __name__ == '__main__':
    main()
