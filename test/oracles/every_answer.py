"""What is answered about hard cases and random pairs, to the bit: a name for each.

    python -m oracles.every_answer KIND ...    pairs of shapes of these kinds

Two processes with different kernels must print the same.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Collection, Iterator
from typing import Any

import numpy as np

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry import (
    ACCURACY_LEVELS,
    AddCompliantHydroelasticProperties,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    MakeRenderEngineExact,
    PerceptionProperties,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.geometry.render.camera_properties import CameraProperties
from drake_geom_ros.math import RigidTransform, RotationMatrix
from truth.bodies.random_bodies import random_body, random_rotation
from truth.hard_cases import cases
from truth.judging.asking import PairScene

KINDS = ('Sphere', 'Box', 'Capsule', 'Cylinder', 'Ellipsoid', 'Convex')
ALL_KINDS = (*KINDS, 'HalfSpace', 'Solid')
_RANDOM = 20  # pairs of each two kinds
_OF_THIS_PROCESS = ('id_A', 'id_B', 'frame_id_A', 'frame_id_B', 'geometry_id', 'id_G')


def digest_of(results: Any) -> str:
    """Return a name for the bits of all arrays and numbers of results, but for ids."""
    digest = hashlib.sha256()
    for name in sorted(each for each in dir(results) if not each.startswith('_')):
        if name.startswith('name_') or name == 'columns':
            continue  # names of geometries are those of one scene
        value = getattr(results, name)
        if isinstance(value, np.ndarray) and name not in _OF_THIS_PROCESS:
            digest.update(f'{name} {value.dtype} {value.shape}'.encode())
            digest.update(value.tobytes())
        elif isinstance(value, (float, int, str)):
            digest.update(f'{name} {value!r}'.encode())
    return digest.hexdigest()[:16]


def answers_about(a: Body, b: Body) -> list[str]:
    """Return names of the answers about a pair: at all levels, by all queries."""
    asked = [PairScene(a, b).distance(level) for level in ACCURACY_LEVELS]
    query = PairScene(a, b).query
    asked += [query.ComputePointPairPenetration()]
    asked += [query.ComputeSignedDistanceToPoint(p) for p in (a.p, b.p, a.p - 0.3)]
    scene = PairScene(a, b)
    ends = FramePoseVector({scene.frames[1]: RigidTransform(b.pose.rotation(), a.p)})
    asked.append(scene.query.CheckMotion(ends))
    return [digest_of(each) for each in asked]


def surfaces_and_images(kind: str) -> list[str]:
    """Return names of contact surfaces of two soft shapes of a kind, and of images of them."""
    rng = np.random.default_rng(KINDS.index(kind))
    graph = SceneGraph()
    graph.AddRenderer('exact', MakeRenderEngineExact())
    source, X_WFs = graph.RegisterSource('soft'), FramePoseVector()
    for name in 'ab':
        shape = random_body(rng, kind, corners=12).shape
        instance = GeometryInstance(RigidTransform(), shape, name)
        properties = ProximityProperties()
        AddCompliantHydroelasticProperties(0.05, 1e5, properties)
        instance.set_proximity_properties(properties)
        instance.set_perception_properties(PerceptionProperties())
        frame = graph.RegisterFrame(source, GeometryFrame(name))
        graph.RegisterGeometry(source, frame, instance)
        R = RotationMatrix(random_rotation(rng))
        X_WFs.set_value(frame, RigidTransform(R, rng.uniform(-0.05, 0.05, 3)))
    context = graph.CreateDefaultContext()
    context.UpdateFramePoses(X_WFs)
    query = graph.get_query_output_port().Eval(context)
    camera = CameraProperties(64, 48, 1.0, 'exact')
    images = query.render_images(
        camera, graph.world_frame_id(), RigidTransform([0.0, 0.0, -0.6]), want=('color', 'depth')
    )
    return [
        digest_of(each) for each in (query.ComputeContactSurfaces(), images.color, images.depth)
    ]


def pairs(kinds: Collection[str]) -> Iterator[tuple[str, Body, Body]]:
    """Return the pairs that are asked about, with names."""
    for case in cases.load():
        if {case.a.kind, case.b.kind} <= set(kinds):
            yield case.id, case.a, case.b
    rng = np.random.default_rng(0)
    both = [(a, b) for a in KINDS for b in KINDS]
    for number, (first, second) in enumerate(_RANDOM * both):
        a, b = (random_body(rng, kind, corners=12) for kind in (first, second))
        placed = b.placed(random_rotation(rng), rng.uniform(-0.3, 0.3, 3))
        if {first, second} <= set(kinds):
            yield f'random {number}', a, placed


def every_answer(kinds: Collection[str]) -> dict[str, list[str]]:
    """Return the names of all answers about the pairs of these kinds of shapes."""
    answers = {name: answers_about(a, b) for name, a, b in pairs(kinds)}
    soft = [kind for kind in kinds if kind in KINDS]
    return answers | {f'soft {kind}': surfaces_and_images(kind) for kind in soft}


if __name__ == '__main__':
    print(json.dumps(every_answer(sys.argv[1:] or ALL_KINDS)))
