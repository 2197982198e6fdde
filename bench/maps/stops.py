"""Missed and false stops, and time, by resolution, noise and extrusion of a scan.

A robot with a round base and a wide tray above stands at random places beside a post, a table or
a crate. Its lidar scans around at a height of 0.2 m; the rule stops it nearer than 0.3 m. The
truth is the distance of the robot from the things as primitives.
"""

from __future__ import annotations

import csv
import time
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from bench.batches.ours import ROOT
from bench.pages import table, three
from drake_geom_ros.geometry import (
    Box,
    Cylinder,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    OccupiedCells,
    ProximityProperties,
    SceneGraph,
    Shape,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensed_maps import Cells

Floats = NDArray[np.float64]

OUT = ROOT / 'docs/accuracy'
ENTER = 0.3  # [m] nearer than this the rule stops
# Base and tray, with the heights of their middles [m].
ROBOT = ((Cylinder(0.2, 0.4), 0.2), (Cylinder(0.45, 0.1), 0.9))
HEIGHT = 1.2  # [m] of columns
LIDAR, RAYS = 0.2, 1080  # height [m], rays around
PLACES = 200  # half of them where the truth is to stop
_FARTHEST = 1.0  # [m] true distances of places
# Boxes: middle and sizes [m].
THINGS: dict[str, list[tuple[Floats, Floats]]] = {
    'post': [(np.array([0.0, 0.0, 0.6]), np.array([0.05, 0.05, 1.2]))],
    'table': [
        (np.array([0.0, 0.0, 0.72]), np.array([1.2, 0.8, 0.04])),
        *(
            (np.array([x, y, 0.35]), np.array([0.05, 0.05, 0.7]))
            for x in (-0.45, 0.45)
            for y in (-0.3, 0.3)
        ),
    ],
    'crate': [(np.array([0.0, 0.0, 0.15]), np.array([0.6, 0.4, 0.3]))],
}
# Resolution [m] and standard deviation of ranges [m].
SETTINGS = ((0.02, 0.01), (0.05, 0.01), (0.1, 0.01), (0.05, 0.0), (0.05, 0.03))


@dataclass(frozen=True)
class Row:
    """Decisions about one kind of thing by maps of one kind."""

    thing: str
    columns: bool
    resolution: float  # [m]
    noise: float  # [m]
    missed: float  # share of the places to stop at
    worst: float  # [m] true distance at the worst missed stop; NaN: none is missed
    false: float  # share of the places that are farther
    cells: float  # in the mean
    milliseconds: float  # from points to distance, mean


def ranges_of(thing: list[tuple[Floats, Floats]], place: Floats, headings: Floats) -> Floats:
    """Return where rays (n,) from a place (2,) at the height of the lidar end [m]; inf: nowhere.

    The slab method for boxes.
    """
    directions = np.stack([np.cos(headings), np.sin(headings)], axis=1)
    ranges = np.full(len(headings), np.inf)
    for middle, size in thing:
        if abs(LIDAR - middle[2]) > 0.5 * size[2]:
            continue
        with np.errstate(divide='ignore'):
            a = (middle[:2] - 0.5 * size[:2] - place) / directions
            b = (middle[:2] + 0.5 * size[:2] - place) / directions
        enters, leaves = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
        hits = (enters <= leaves) & (enters >= 0.0)
        ranges = np.where(hits, np.minimum(ranges, enters), ranges)
    return ranges


def distance(place: Floats, things: list[tuple[Shape, RigidTransform]]) -> float:
    """Return the distance [m] of the robot at a place (2,) from shapes in the world."""
    graph = SceneGraph()
    source = graph.RegisterSource('stops')
    robot = graph.RegisterFrame(source, GeometryFrame('robot'))
    parts = [(shape, RigidTransform([0.0, 0.0, height]), robot) for shape, height in ROBOT]
    parts += [(shape, X_WG, graph.world_frame_id()) for shape, X_WG in things]
    for number, (shape, X_FG, frame) in enumerate(parts):
        instance = GeometryInstance(X_FG, shape, f'{number}')
        instance.set_proximity_properties(ProximityProperties())
        graph.RegisterGeometry(source, frame, instance)
    context = graph.CreateDefaultContext()
    X_WR = RigidTransform([*place, 0.0])
    context.UpdateFramePoses(FramePoseVector({robot: X_WR}))
    query = graph.get_query_output_port().Eval(context)
    return float(query.ComputeSignedDistancePairwiseClosestPoints().distance.min())


def places_beside(thing: str, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Return places (n, 2) and true distances (n,) [m], half of them nearer than ENTER."""
    boxes = [(Box(*size), RigidTransform(middle)) for middle, size in THINGS[thing]]
    near: list[tuple[Floats, float]] = []
    far: list[tuple[Floats, float]] = []
    while min(len(near), len(far)) < PLACES // 2:
        place = rng.uniform(-2.0, 2.0, 2)
        true = distance(place, boxes)
        if 0.0 < true < _FARTHEST:
            (near if true < ENTER else far).append((place, true))
    both = near[: PLACES // 2] + far[: PLACES // 2]
    return np.array([place for place, _ in both]), np.array([true for _, true in both])


def row_of(
    thing: str, columns: bool, resolution: float, noise: float, places: Floats, truth: Floats
) -> Row:
    """Return the decisions at places (n, 2) with true distances (n,) [m]."""
    rng = np.random.default_rng(1)
    headings = np.linspace(-np.pi, np.pi, RAYS, endpoint=False)
    seen, counts, seconds = np.full(len(places), np.inf), [], []
    for k, place in enumerate(places):
        ranges = ranges_of(THINGS[thing], place, headings)
        hits = np.isfinite(ranges)
        if not hits.any():
            continue
        lengths = np.maximum(ranges[hits] + rng.normal(0.0, noise, int(hits.sum())), 0.0)
        ends = np.stack([np.cos(headings[hits]), np.sin(headings[hits])], axis=1)
        ends = place + lengths[:, np.newaxis] * ends
        start = time.process_time()
        points = np.column_stack([ends, np.full(len(ends), LIDAR)])
        cells = Cells.of_points(points, resolution)
        if columns:
            cells = cells.extruded(0.0, HEIGHT)
        seen[k] = distance(place, [(OccupiedCells(resolution, cells.centres()), RigidTransform())])
        seconds.append(time.process_time() - start)
        counts.append(len(cells))
    stops, stopped = truth < ENTER, seen < ENTER
    missed = stops & ~stopped
    return Row(
        thing,
        columns,
        resolution,
        noise,
        float(missed.sum() / stops.sum()),
        float(truth[missed].min()) if missed.any() else float('nan'),
        float((stopped & ~stops).sum() / (~stops).sum()),
        float(np.mean(counts)) if counts else 0.0,
        float(1e3 * np.mean(seconds)) if seconds else 0.0,
    )


def measure() -> list[Row]:
    """Return a row for each thing, with and without columns, and each setting."""
    rows = []
    for thing in THINGS:
        places, truth = places_beside(thing, np.random.default_rng(0))
        rows += [
            row_of(thing, columns, *setting, places, truth)
            for columns in (False, True)
            for setting in SETTINGS
        ]
    return rows


_PAGE = """# Stops by the resolution, noise and columns of a scan

Generated by `python -m bench.maps stops`; each row is a line of [stops.csv](stops.csv).
[What the resolution of a map costs](maps.md) has errors of distances.

A robot has a round base of radius 0.2 m, up to 0.4 m high, and a round tray of radius 0.45 m at
0.9 m. It stands at {places} random places beside a thing: a post, a table of which the lidar sees
the legs, or a crate of 0.3 m that the tray passes over. Half of the places are nearer than
{enter} m, all nearer than {farthest} m.

A lidar in its middle, {lidar} m above the floor, sees {rays} rays around, with a normal error of
each range. The cells of their ends are the map; as columns each stands for all heights from 0 to
{height} m (`extrude`). The rule stops the robot where the map is nearer than {enter} m. The truth
is the distance from the thing itself.

- A stop is *missed* where the truth is nearer and the map is not. Fewer are better.
- A stop is *false* where the map is nearer and the truth is not. Fewer are better.
- Times are of the processor, one thread, from points to the distance, all of one run.

{table}

What the table shows:

- Without columns nothing of a post is at the height of the tray, and most stops are missed. With
  columns none is.
- Columns cost false stops beside what is lower than they are: the crate.
- Larger cells and noise cost false stops, for the map reaches farther towards the robot. Neither
  costs a missed stop.
- The top of the table reaches beyond its legs and is in no map, so stops are missed with columns
  too: a second sensor has to see it, or the scene has to hold it.
- What is lower than the plane of the lidar is in no row: it is never seen, no stop comes.
"""


def run() -> None:
    """Write the rows and the page."""
    write(measure())


def write(rows: list[Row]) -> None:
    """Write rows and the page of them."""
    with (OUT / 'stops.csv').open('w', newline='') as file:
        writer = csv.DictWriter(file, fieldnames=list(asdict(rows[0])), lineterminator='\n')
        writer.writeheader()
        writer.writerows([asdict(row) for row in rows])
    heads = (
        *('thing', 'columns', 'edge of a cell [m]', 'noise [m]', 'missed [%]'),
        *('nearest missed [m]', 'false [%]', 'cells', 'time [ms]'),
    )
    lines = [
        (
            *(row.thing, 'yes' if row.columns else 'no', f'{row.resolution:g}', f'{row.noise:g}'),
            *(f'{100.0 * row.missed:.0f}', '-' if np.isnan(row.worst) else f'{row.worst:.2f}'),
            *(f'{100.0 * row.false:.0f}', f'{row.cells:.0f}', three(row.milliseconds)),
        )
        for row in rows
    ]
    text = _PAGE.format(
        height=f'{HEIGHT:g}',
        places=PLACES,
        enter=f'{ENTER:g}',
        farthest=f'{_FARTHEST:g}',
        lidar=f'{LIDAR:g}',
        rays=RAYS,
        table=table(heads, lines).rstrip(),
    )
    (OUT / 'stops.md').write_text(text)
