"""What ``resolution_hint`` costs: error against closed forms, time and memory, beside pydrake."""

from __future__ import annotations

import gc
import importlib
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib import pyplot
from numpy.typing import NDArray

from bench.pages import description, legend_below, table, three, versions, write_rows
from truth.bodies.random_bodies import random_rotation
from truth.surfaces.closed_forms import (
    DEPTH,
    MODULUS,
    RADIUS,
    SIZE,
    Truth,
    ball_in_ball,
    ball_in_plane,
    box_on_plane,
)

matplotlib.use('Agg')
Floats = NDArray[np.float64]

OUT = Path(__file__).resolve().parents[2] / 'docs/accuracy'
HINTS = (0.05, 0.025, 0.0125, 0.00625, 0.003125)  # [m]
TURNS = 12  # random orientations of a ball's mesh
PACKAGES = ('drake_geom_ros', 'pydrake')
COLOURS = {'drake_geom_ros': '#1f5fb4', 'pydrake': '#d9822b'}
MARKS = {'ball in plane': 'o-', 'ball in ball': 's--'}
COPIES = 8  # bodies that memory is looked at with


@dataclass(frozen=True)
class Row:
    """A scene with meshes of one hint, in one package."""

    scene: str
    package: str
    hint: float  # [m]
    elements: int  # of the soft body
    polygons: float  # mean
    area: float  # error, as a part of the truth: root of the mean square over the turns
    force: float
    centre: float  # of pressure: as a part of the patch's half width
    milliseconds: float  # of a query: median
    slow: float  # 99th percentile
    mebibytes: float  # of one soft body


@dataclass(frozen=True)
class Scene:
    """A soft body above a rigid one whose middle is the origin."""

    soft: tuple[str, tuple[float, ...]]
    rigid: tuple[str, tuple[float, ...]]
    height: float  # of the soft one's middle [m]
    turned: bool
    truth: Callable[[], Truth]


BALL = ('Sphere', (RADIUS,))
SCENES = {
    'ball in plane': Scene(BALL, ('HalfSpace', ()), RADIUS - DEPTH, True, ball_in_plane),
    'ball in ball': Scene(BALL, BALL, 2.0 * RADIUS - DEPTH, True, ball_in_ball),
    'box on plane': Scene(
        ('Box', SIZE), ('HalfSpace', ()), 0.5 * SIZE[2] - DEPTH, False, box_on_plane
    ),
}


class Pressing:
    """A scene in a package."""

    def __init__(
        self, package: str, bodies: list[tuple[str, tuple[float, ...], float]], hint: float
    ):
        self.geometry = importlib.import_module(f'{package}.geometry')
        self.math = importlib.import_module(f'{package}.math')
        self.graph = self.geometry.SceneGraph()
        source = self.graph.RegisterSource('bodies')
        self.frames, self.ids = [], []
        for number, (kind, sizes, modulus) in enumerate(bodies):
            properties = self.geometry.ProximityProperties()
            if modulus > 0.0:
                self.geometry.AddCompliantHydroelasticProperties(hint, modulus, properties)
            else:
                self.geometry.AddRigidHydroelasticProperties(hint, properties)
            shape = getattr(self.geometry, kind)(*sizes)
            instance = self.geometry.GeometryInstance(
                self.math.RigidTransform(), shape, f'body{number}'
            )
            instance.set_proximity_properties(properties)
            frame = self.graph.RegisterFrame(source, self.geometry.GeometryFrame(f'f{number}'))
            self.frames.append(frame)
            self.ids.append(self.graph.RegisterGeometry(source, frame, instance))
        self.context = self.graph.CreateDefaultContext()
        self.port = self.graph.get_source_pose_port(source)
        self.query = self.graph.get_query_output_port().Eval(self.context)

    def elements(self) -> int:
        """Return how many tetrahedra the first body has."""
        mesh = self.graph.model_inspector().maybe_get_hydroelastic_mesh(self.ids[0])
        return int(mesh.num_elements())

    def asked(self, poses: list[tuple[Floats, Floats]]) -> tuple[float, Any]:
        """Return the milliseconds of an answer, and its surfaces."""
        vector = self.geometry.FramePoseVector()
        for frame, (R, p) in zip(self.frames, poses, strict=True):
            vector.set_value(frame, self.math.RigidTransform(self.math.RotationMatrix(R), p))
        self.port.FixValue(self.context, vector)
        time.sleep(0.01)
        start = time.perf_counter()
        surfaces = self.query.ComputeContactSurfaces(
            self.geometry.HydroelasticContactRepresentation.kPolygon
        )
        return 1e3 * (time.perf_counter() - start), surfaces


def summed(surface: Any) -> tuple[float, float, Floats]:
    """Return area, upward force on the soft body, which is M, and centre of pressure.

    By the methods that both packages have, of each face: a pressure is linear on it.
    """
    force, pressed, moment = 0.0, 0.0, np.zeros(3)
    field, mesh = surface.poly_e_MN(), surface.poly_mesh_W()
    for k in range(surface.num_faces()):
        rows = [mesh.element(k).vertex(i) for i in range(mesh.element(k).num_vertices())]
        corners = np.array([mesh.vertex(row) for row in rows])
        values = np.array([field.EvaluateAtVertex(row) for row in rows])
        for i in range(1, len(rows) - 1):
            x, p = corners[[0, i, i + 1]], values[[0, i, i + 1]]
            area = 0.5 * float(np.linalg.norm(np.cross(x[1] - x[0], x[2] - x[0])))
            pressed += area * p.mean()
            moment += area / 12.0 * (p.sum() * x.sum(axis=0) + p @ x)
            force += area * p.mean() * float(surface.face_normal(k)[2])
    return surface.total_area(), force, moment / pressed


def measured(name: str, hint: float, memory: dict[str, float]) -> list[Row]:
    """Return the rows of a scene with meshes of a hint, of both packages, asked in turns."""
    scene, random = SCENES[name], np.random.default_rng(0)
    bodies = [(*scene.soft, MODULUS), (*scene.rigid, 0.0)]
    sides = {package: Pressing(package, bodies, hint) for package in PACKAGES}
    truth = scene.truth()
    errors: dict[str, list[tuple[float, ...]]] = {package: [] for package in PACKAGES}
    times: dict[str, list[float]] = {package: [] for package in PACKAGES}
    for turn in range(TURNS * 3):
        R = random_rotation(random) if scene.turned else np.eye(3)
        S = random_rotation(random) if scene.rigid == BALL else np.eye(3)
        poses = [(R, np.array([0.0, 0.0, scene.height])), (S, np.zeros(3))]
        for package, side in sides.items():
            took, surfaces = side.asked(poses)
            if turn:  # the first may compile
                times[package].append(took)
            if turn < TURNS:
                errors[package].append(_errors(surfaces, truth))
    rows = []
    for package, side in sides.items():
        columns = np.array(errors[package])
        rms = np.sqrt(np.nanmean(columns**2, axis=0))
        spent = np.array(times[package])
        rows.append(
            Row(
                scene=name,
                package=package,
                hint=hint,
                elements=side.elements(),
                polygons=float(columns[:, 3].mean()),
                area=float(rms[0]),
                force=float(rms[1]),
                centre=float(rms[2]),
                milliseconds=float(np.median(spent)),
                slow=float(np.percentile(spent, 99)),
                mebibytes=memory[package],
            )
        )
    return rows


def _errors(surfaces: Any, truth: Truth) -> tuple[float, ...]:
    """Return errors of area, force and centre, as parts of the truth, and how many polygons."""
    if not surfaces:  # so coarse that the meshes do not meet
        return -1.0, -1.0, np.nan, 0.0
    area, force, centre = summed(surfaces[0])
    off = float(np.linalg.norm(centre - np.array([0.0, 0.0, truth.height])))
    errors = area / truth.area - 1.0, force / truth.force - 1.0, off / truth.width
    return *errors, float(surfaces[0].num_faces())


def memory_of(package: str, name: str, hint: float) -> float:
    """Return the MiB that a soft body takes, asked about once: a process of its own tells."""
    command = [sys.executable, '-m', 'bench.surfaces', 'memory', package, name, str(hint)]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return float(told)


def tell_memory(package: str, name: str, hint: float) -> None:
    """Print by how much memory grows for COPIES of a scene's soft body, each [MiB]."""
    scene = SCENES[name]
    kind, sizes = scene.soft

    def pressing(k: int) -> Pressing:
        # Each of another size, that nothing is shared.
        soft = (kind, tuple(size * (1.0 + 1e-9 * k) for size in sizes), MODULUS)
        side = Pressing(package, [soft, ('HalfSpace', (), 0.0)], hint)
        side.asked([(np.eye(3), np.array([0.0, 0.0, 0.9 * min(sizes)])), (np.eye(3), np.zeros(3))])
        return side

    kept = [pressing(0)]
    gc.collect()
    before = resident()
    kept += [pressing(k) for k in range(1, COPIES + 1)]
    gc.collect()
    print((resident() - before) / COPIES)


def resident() -> float:
    """Return the memory [MiB] of this process."""
    pages = int(Path('/proc/self/statm').read_text(encoding='ascii').split()[1])
    return pages * os.sysconf('SC_PAGESIZE') / 2**20


def draw(rows: list[Row], path: Path) -> None:
    """Write the picture: errors, time and memory by hint."""
    figure, panels = pyplot.subplots(2, 3, figsize=(12.0, 7.2), layout='constrained')
    columns = ('area', 'force', 'centre', 'milliseconds', 'mebibytes')
    told = (
        'error of area, part of it',
        'error of force, part of it',
        'centre of pressure is off,\npart of the half width',
        'time of a query, median [ms]',
        'memory of a body [MiB]',
    )
    for panel, column, label in zip(panels.flat, columns, told, strict=False):
        # The soft ball is the same in both.
        names = {'ball in plane': 'o-'} if column == 'mebibytes' else MARKS
        for name, mark in names.items():
            for package in PACKAGES:
                some = [row for row in rows if (row.scene, row.package) == (name, package)]
                panel.loglog(
                    [1e3 * row.hint for row in some],
                    [getattr(row, column) for row in some],
                    mark,
                    color=COLOURS[package],
                    markersize=9 if package == 'pydrake' else 5,
                    fillstyle='none' if package == 'pydrake' else 'full',
                    label=f'{name}, {package}',
                )
        panel.set_xticks([1e3 * hint for hint in HINTS], [f'{1e3 * hint:.3g}' for hint in HINTS])
        panel.minorticks_off()
        panel.set_xlabel('resolution_hint [mm]')
        panel.set_ylabel(label)
        panel.grid(alpha=0.3)
    panels[1, 2].set_axis_off()
    legend_below(figure, 4)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)


_PAGE = """# What resolution_hint costs

Generated by `python -m bench.surfaces resolution`; each row is a line of
[surfaces.csv](surfaces.csv). [Contact surfaces](../contact_surfaces.md) describes the answers.

![Error, time and memory by resolution_hint](surfaces.png)

A soft ball of radius {radius} m is pressed {depth} m into a rigid plane, and as deep into a rigid
ball of its size. The truth is a closed form of the pressure E (1 - r / R) over a disc, and over a
cap by a quadrature of 60 points. A mesh presses otherwise on its corners than on its faces, so
both balls are turned at random, {turns} times. An error is the root of the mean square over these
turns.

The largest hint makes an octahedron, which may miss bodies that the ball would touch. All of area
and force is then counted as missing, and the centre is left out. Half the hint makes four times as
many elements, since all of them reach from the surface to the middle, and a quarter of the error.

A box on a plane is the truth whatever the hint, since its pressure is linear in each of its
elements.

Each package is asked in turns in one process, of one thread. All bodies move before each question,
and 10 ms go by. Times are those of a machine with other work beside it: compare them. Memory is
the growth of a separate process, for each of {copies} bodies, no two of one size, after one
question about each.

{table}

{machine}. Versions: {versions}.
"""


def run() -> None:
    """Write the rows, the picture and the page."""
    rows: list[Row] = []
    balls: dict[float, dict[str, float]] = {}  # memory, by hint: of one ball in two scenes
    for name, scene in SCENES.items():
        for hint in HINTS[:1] if name == 'box on plane' else HINTS:
            if scene.soft == BALL and hint in balls:
                memory = balls[hint]
            else:
                memory = {package: memory_of(package, name, hint) for package in PACKAGES}
            if scene.soft == BALL:
                balls[hint] = memory
            rows += measured(name, hint, memory)
            for row in rows[-2:]:
                print(row)
    write_rows(OUT / 'surfaces.csv', rows)
    draw(rows, OUT / 'surfaces.png')
    heads = (
        *('scene', 'package', 'hint [mm]', 'elements', 'polygons', 'area', 'force'),
        *('centre of pressure', 'time, median [ms]', 'p99', 'memory [MiB]'),
    )
    lines = [
        (
            *(row.scene, row.package, f'{1e3 * row.hint:g}', row.elements, f'{row.polygons:.0f}'),
            *(_part(row.area), _part(row.force), _part(row.centre)),
            *(three(row.milliseconds), three(row.slow), three(row.mebibytes)),
        )
        for row in rows
    ]
    found = ', '.join(f'{name} {version}' for name, version in versions(['pydrake']).items())
    text = _PAGE.format(
        radius=RADIUS,
        depth=DEPTH,
        turns=TURNS,
        copies=COPIES,
        table=table(heads, lines).rstrip(),
        machine=description(),
        versions=found,
    )
    (OUT / 'surfaces.md').write_text(text)


def _part(value: float) -> str:
    """Return an error as a part of the truth, in words a table has room for."""
    return '< 1e-12' if value < 1e-12 else f'{100.0 * value:.2g} %'
