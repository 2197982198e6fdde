"""Time of colour, depth and label images: our engines, pydrake's RenderEngineVtk, and moderngl.

    ./run exec python -m bench.images [--rounds 9] [--out out/images.json]
    ./run exec python -m bench.images.plot out/images.json docs/images_cost.png

Two arms and a table at 640 x 480, one script under both imports, and how their images differ; then
times over pixels, primitives and triangles. Each engine has a process of its own, one after the
other. Medians of milliseconds of processor time, that of a driver's threads included: figures of
one run compare with one another. Memory is the largest resident set of the process.
"""

import argparse
import json
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from bench.images import moderngl_side as images_moderngl
from bench.images.scenes import (
    FAR,
    FOV_Y,
    HEIGHT,
    LIBRARIES,
    NEAR,
    WIDTH,
    Library,
    arms_and_table,
    balls,
    cameras,
    looking,
    mesh,
    ours,
    pydrakes,
    query_of,
)

# Farther from one another than this, depths are of different surfaces: beside a silhouette.
OTHER_SURFACE = 0.02  # [m]
PRIMITIVES = (10, 100, 1000, 10_000)
TRIANGLES = (1000, 10_000, 100_000, 1_000_000)
# With 10 000 primitives pydrake was stopped at 10 GB of memory, and our VTK after four minutes.
FEWER = {'pydrake': PRIMITIVES[:-1], 'VTK': PRIMITIVES[:-1]}
PATIENCE = 60.0  # [s] with a scene, after which no larger one is tried
# Nearer than this, they are of faces that lie in each other, and either label is right.
SAME_DEPTH = 1e-5  # [m]


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


def together(library: Library, query: Any, seen: tuple[Any, Any]) -> Any:
    """Return the three images in one pass, which is ours."""
    W, X = library.geometry.SceneGraph.world_frame_id(), looking(library)
    return query.render_images(seen[1], W, X)


def spent(
    library: Library, bodies: list[Any], rounds: int, size: tuple[int, int] = (WIDTH, HEIGHT)
) -> float:
    """Return the processor time [ms] of three images, in one pass where it can be."""
    if library.drawer is not None:
        intrinsics = library.sensors.CameraInfo(*size, FOV_Y)
        camera = images_moderngl.Camera(looking(library), intrinsics, NEAR, FAR)
        return milliseconds(library.drawer(bodies, camera), rounds)[0]
    query, *kept = query_of(library, bodies)
    task = together if hasattr(query, 'render_images') else three_calls
    used, _ = milliseconds(partial(task, library, query, cameras(library, *size)), rounds)
    del kept
    return used


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
    gaps[both] = np.abs(depths[0][both] - depths[1][both])
    same = gaps <= SAME_DEPTH
    inside = gaps[labels & (gaps < OTHER_SURFACE)]
    return {
        'pixels_of_other_label': int((~labels).sum()),
        'of_these_of_one_depth': int((~labels & same).sum()),
        'of_the_rest_away_from_silhouettes': int((~labels & ~same & ~beside).sum()),
        'median_depth_difference_m': float(np.median(inside)),
        'largest_depth_difference_m': float(inside.max()),
    }


def difference() -> dict[str, Any]:
    """Return how images of ours and of pydrake differ; nothing where it is not installed."""
    made = []
    for library in filter(None, (ours(), pydrakes())):
        query, *kept = query_of(library, arms_and_table(library))
        made.append(three_calls(library, query, cameras(library)))
        del kept
    return compared(*made) if len(made) > 1 else {}


def measured(name: str, rounds: int) -> dict[str, Any]:
    """Return times [ms] of an engine by what was drawn; nothing where it cannot draw here."""
    library = LIBRARIES[name]()
    if library is None:
        return {}
    found: dict[str, Any] = {}
    if library.drawer is None:
        query, *kept = query_of(library, arms_and_table(library))
        calls = partial(three_calls, library, query, cameras(library))
        found['three calls: used, wall'] = milliseconds(calls, rounds)
        del kept
    found['three images'] = spent(library, arms_and_table(library), rounds)
    found['arms MB'] = memory()
    found['pixels'] = {
        width * width * 3 // 4: spent(library, arms_and_table(library), 3, (width, width * 3 // 4))
        for width in (160, 320, 640, 1280, 2560)
    }
    # Scenes are made outside: where making one takes minutes, images of larger ones are not told.
    primitives = FEWER.get(name, PRIMITIVES)
    for what, make, counts in (('primitives', balls, primitives), ('triangles', mesh, TRIANGLES)):
        found[what] = {}
        for count in counts:
            start = time.perf_counter()
            found[what][count] = spent(library, make(library, count), 3)
            if time.perf_counter() - start > PATIENCE:
                break
    found['MB'] = memory()
    return found


def memory() -> float:
    """Return the largest resident set of this process so far [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def in_a_process(name: str, rounds: int) -> dict[str, Any]:
    """Return what is measured of an engine in a process of its own, for its memory."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'found.json'
        words = ['--engine', name, '--rounds', str(rounds), '--out', str(path)]
        subprocess.run([sys.executable, '-m', 'bench.images', *words], check=True)
        found: dict[str, Any] = json.loads(path.read_text())
    return found


def main() -> None:
    """Measure and print, and write a file where one is named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--rounds', type=int, default=9)
    parser.add_argument('--out', help='JSON file')
    parser.add_argument('--engine', choices=tuple(LIBRARIES), help='only this one')
    parser.add_argument('--compare', action='store_true', help='only how images differ')
    options = parser.parse_args()
    if options.compare:
        found = difference()
    elif options.engine:
        found = measured(options.engine, options.rounds)
    else:
        found = {name: in_a_process(name, options.rounds) for name in LIBRARIES}
        found['difference'] = difference()
    for name, value in found.items():
        print(f'{name:32}', json.dumps(value))
    if options.out:
        Path(options.out).parent.mkdir(parents=True, exist_ok=True)
        Path(options.out).write_text(json.dumps(found, indent=1))


if __name__ == '__main__':
    main()
