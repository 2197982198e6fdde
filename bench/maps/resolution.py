"""What the resolution of a map costs: error against the surface that was scanned, time, memory."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib import pyplot
from numpy.typing import NDArray

from bench.batches.ours import ROOT
from bench.maps.scenes import sheet
from bench.pages import table, three, write_rows
from drake_geom_ros.geometry import (
    Box,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    OccupiedCells,
    PointCloud,
    ProximityProperties,
    QueryObject,
    SceneGraph,
    SceneGraphContext,
    Shape,
    Sphere,
)
from drake_geom_ros.geometry.shapes.primitives import for_queries
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensed_maps import Cells

matplotlib.use('Agg')

Floats = NDArray[np.float64]

RESOLUTIONS = (0.1, 0.05, 0.025, 0.0125, 0.00625)  # [m]
PROBE = Sphere(0.05)
BALL, TABLE = Sphere(0.3), Box(1.2, 1.2, 0.5)
_X_WT = RigidTransform([0.0, 0.0, -0.55])
_DRAWN = 1500  # places, of which those count where the probe touches nothing
_STEP = 0.3  # of a cell: how far apart scanned points are at most
OUT = ROOT / 'docs/accuracy'


@dataclass(frozen=True)
class Row:
    """One map of one resolution, and what distances from it are."""

    kind: str
    resolution: float  # [m]
    cells: int
    nearer: float  # [m] by which the map is nearer than the surface, in the mean
    most_nearer: float
    most_farther: float  # [m] by which it is farther, at most
    microseconds: float  # of a query, mean
    slow: float  # its 99th percentile
    mebibytes: float  # as packed


def scanned(step: float, rng: np.random.Generator) -> Floats:
    """Return points on the ball and on the top of the table, no farther apart than a step [m]."""
    count = round(4.0 * np.pi * (2.0 * BALL.radius() / step) ** 2)
    directions = rng.normal(size=(count, 3))
    on_ball = BALL.radius() * directions / np.linalg.norm(directions, axis=1)[:, None]
    half, top = 0.5 * TABLE.width(), _X_WT.translation()[2] + 0.5 * TABLE.height()
    return np.concatenate((on_ball, sheet(step, (-half, half), (-half, half), (top, top))))


class Probe:
    """A ball that moves beside anchored shapes."""

    def __init__(self, *shapes: tuple[Shape, RigidTransform]) -> None:
        graph = SceneGraph()
        source = graph.RegisterSource('probe')
        self._frame = graph.RegisterFrame(source, GeometryFrame('probe'))
        for number, (shape, X_WG) in enumerate(((PROBE, RigidTransform()), *shapes)):
            instance = GeometryInstance(X_WG, shape, f'{number}')
            instance.set_proximity_properties(ProximityProperties())
            frame = graph.world_frame_id() if number else self._frame
            graph.RegisterGeometry(source, frame, instance)
        self._context: SceneGraphContext = graph.CreateDefaultContext()
        self._query: QueryObject = graph.get_query_output_port().Eval(self._context)

    def distances(self, places: Floats) -> tuple[Floats, Floats]:
        """Return the least distance at each of the places (n, 3), and processor times [s]."""
        least, seconds = np.empty(len(places)), np.empty(len(places))
        for k, place in enumerate(places):
            poses = FramePoseVector({self._frame: RigidTransform(place)})
            self._context.UpdateFramePoses(poses)
            start = time.process_time()
            found = self._query.ComputeSignedDistancePairwiseClosestPoints()
            least[k] = found.distance.min()
            seconds[k] = time.process_time() - start
        return least, seconds


def measure() -> tuple[int, list[Row]]:
    """Return how many places were asked about, and a row for each kind and resolution."""
    rng = np.random.default_rng(0)
    # Above the table and beside the ball, where both surfaces were scanned.
    places = rng.uniform((-0.5, -0.5, -0.2), (0.5, 0.5, 0.8), (_DRAWN, 3))
    truth, _ = Probe((BALL, RigidTransform()), (TABLE, _X_WT)).distances(places)
    places, truth = places[truth > 0.0], truth[truth > 0.0]
    rows = []
    for resolution in RESOLUTIONS:
        cells = Cells.of_points(scanned(_STEP * resolution, rng), resolution).centres()
        shapes = (
            OccupiedCells(resolution, cells),
            PointCloud(0.5 * resolution, cells),
        )
        for shape in shapes:
            probe = Probe((shape, RigidTransform()))
            probe.distances(places[:50])
            found, seconds = probe.distances(places)
            nearer = np.where(found > 0.0, truth - found, np.nan)
            packed = for_queries(shape).in_pairs.parameters
            rows.append(
                Row(
                    type(shape).__name__,
                    resolution,
                    len(cells),
                    float(np.nanmean(nearer)),
                    float(np.nanmax(nearer)),
                    float(-np.nanmin(nearer)),
                    float(1e6 * seconds.mean()),
                    float(1e6 * np.percentile(seconds, 99)),
                    packed.nbytes / 2**20,
                )
            )
    return len(places), rows


def draw(rows: list[Row], path: Path) -> None:
    """Write the picture: error, time and memory by resolution."""
    figure, panels = pyplot.subplots(1, 3, figsize=(12.0, 4.0), layout='constrained')
    for kind, colour in (('OccupiedCells', '#1f5fb4'), ('PointCloud', '#d9822b')):
        some = [row for row in rows if row.kind == kind]
        edges = [1e3 * row.resolution for row in some]
        panels[0].plot(
            edges, [1e3 * r.most_nearer for r in some], 'o-', color=colour, label=f'{kind}: nearer'
        )
        panels[0].plot(
            edges,
            [1e3 * max(r.most_farther, 0.0) for r in some],
            's--',
            color=colour,
            label=f'{kind}: farther',
        )
        panels[1].plot(edges, [r.microseconds for r in some], 'o-', color=colour, label=kind)
        panels[2].plot(edges, [r.mebibytes for r in some], 'o-', color=colour, label=kind)
    for panel, told in zip(
        panels, ('error at most [mm]', 'time of a query, mean [us]', 'memory [MiB]'), strict=True
    ):
        panel.set_xscale('log')
        panel.set_xlabel('edge of a cell, twice the radius of a ball [mm]')
        panel.set_ylabel(told)
        panel.legend(frameon=False)
        panel.grid(alpha=0.3)
    panels[2].set_yscale('log')
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


_PAGE = """# What the resolution of a map costs

Generated by `python -m bench.maps resolution`; each row is a line of [maps.csv](maps.csv).
[Sensed maps](../sensed_maps.md) says what the shapes are, and
[stops](stops.md) shows what resolution, noise and
extrusion cost a stop rule: missed and false stops, and time.

![Error, time and memory by resolution](maps.png)

A ball of radius 0.3 m stands over a table. Both are scanned without noise at {step} of a cell. The
points make the cells of a grid, or balls of half an edge around the middles of these. A probe of
radius 0.05 m is asked for its distance at {count} places where it touches neither. The truth is
its distance from the ball and from the table as primitives. No error is counted where it overlaps
the map.

Cells hold every scanned point, so a map is farther than the surface only by the part between the
points. Balls leave the corners of cells out. Times are of the processor, one thread, all of one
run: compare them.

{table}
"""


def run() -> None:
    """Write the rows, the picture and the page."""
    count, rows = measure()
    write_rows(OUT / 'maps.csv', rows)
    draw(rows, OUT / 'maps.png')
    heads = (
        *('shape', 'edge or diameter [m]', 'cells', 'nearer, mean [mm]', 'at most'),
        *('farther at most [mm]', 'query, mean [us]', 'p99', 'memory [MiB]'),
    )
    lines = [
        (
            *(row.kind, f'{row.resolution:g}', str(row.cells), three(1e3 * row.nearer)),
            *(three(1e3 * row.most_nearer), three(abs(1e3 * max(row.most_farther, 0.0)))),
            *(three(row.microseconds), three(row.slow), three(row.mebibytes)),
        )
        for row in rows
    ]
    text = _PAGE.format(step=_STEP, count=count, table=table(heads, lines).rstrip())
    (OUT / 'maps.md').write_text(text)
