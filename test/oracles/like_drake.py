"""Comparison of a loaded model with the plant that pydrake's parser makes of the same file."""

import re
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

import numpy as np

from drake_geom_ros.geometry import FramePoseVector, Role, SceneGraph
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import WORLD, read_scene, register
from drake_geom_ros.scene_files.directives import values_of_drake
from drake_geom_ros.trajectories.kinematics import Kinematics


@dataclass
class Facts:
    """Shapes, poses in the world and candidate pairs, by ``(link, index on it)``."""

    shapes: dict
    names: dict
    X_WGs: dict
    pairs: set
    distances: dict


def plant_of(file, package_roots=(), text='', kind=''):
    """Return pydrake's plant, scene graph and diagram of a model file."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    parser = Parser(plant)
    packages = parser.package_map()
    for root in map(Path, package_roots):
        named = re.search('<name>(.*)</name>', (root / 'package.xml').read_text())[1]
        if packages.Contains(named):
            packages.Remove(named)
        packages.Add(named, str(root))
    parser.AddModelsFromString(text, kind) if text else parser.AddModels(str(file))
    plant.Finalize()
    return plant, scene_graph, builder.Build()


def shape_key(shape):
    """Return the kind and the sizes of a shape of either library."""
    kind = type(shape).__name__
    if kind in ('Mesh', 'Convex'):
        scale = np.broadcast_to(shape.scale3(), 3)
        return kind, Path(shape.source().path()).name, *np.round(scale, 12).tolist()
    sizes = {
        'Sphere': ('radius',),
        'Box': ('width', 'depth', 'height'),
        'Cylinder': ('radius', 'length'),
        'Capsule': ('radius', 'length'),
        'Ellipsoid': ('a', 'b', 'c'),
        'HalfSpace': (),
    }[kind]
    return kind, *(round(getattr(shape, size)(), 12) for size in sizes)


def of_drake(plant, scene_graph, diagram, rng, within=0.3, mimics=None):
    """Return the facts of a plant at random joint values, these values, and poses of bodies."""
    context = diagram.CreateDefaultContext()
    inside = plant.GetMyMutableContextFromRoot(context)
    q = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        if joint.num_positions() == 0 or joint.type_name() == 'quaternion_floating':
            continue
        low = np.maximum(joint.position_lower_limits(), -1.0)
        high = np.minimum(joint.position_upper_limits(), 1.0)
        if (low > high).any():
            low, high = joint.position_lower_limits(), joint.position_lower_limits()
        values = rng.uniform(low, high)
        if mimic := (mimics or {}).get(scoped(plant, joint)):
            values = mimic.multiplier * q[mimic.joint] + mimic.offset
        q[scoped(plant, joint)] = values
        positions = plant.GetPositions(inside)
        start = joint.position_start()
        positions[start : start + joint.num_positions()] = values
        plant.SetPositions(inside, positions)
    query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
    inspector = scene_graph.model_inspector()
    keys, counts = {}, {}
    from pydrake.geometry import Role as DrakesRole

    for id in sorted(
        inspector.GetAllGeometryIds(DrakesRole.kProximity), key=lambda g: g.get_value()
    ):
        body = plant.GetBodyFromFrameId(inspector.GetFrameId(id))
        link = scoped(plant, body) if body.index() != plant.world_body().index() else WORLD
        counts[link] = counts.get(link, -1) + 1
        keys[id] = (link, counts[link])
    pairs = {frozenset((keys[a], keys[b])) for a, b in inspector.GetCollisionCandidates()}
    distances = {}
    try:
        for pair in query.ComputeSignedDistancePairwiseClosestPoints(within):
            distances[frozenset((keys[pair.id_A], keys[pair.id_B]))] = pair.distance
    except RuntimeError:
        distances = None
    poses = {}
    for index in range(plant.num_bodies()):
        body = plant.get_body(plant.world_body().index().__class__(index))
        poses[scoped(plant, body)] = plant.EvalBodyPoseInWorld(inside, body).GetAsMatrix4()
    facts = Facts(
        {key: shape_key(inspector.GetShape(id)) for id, key in keys.items()},
        {key: inspector.GetName(id).rpartition('::')[2] for id, key in keys.items()},
        {key: query.GetPoseInWorld(id).GetAsMatrix4() for id, key in keys.items()},
        pairs,
        distances,
    )
    return facts, q, poses


def mimics_of(scene):
    """Return the mimics of a description by scoped joint, each with the scoped leader."""
    return {
        f'{robot.name}::{joint.name}': replace(
            joint.mimic, joint=f'{robot.name}::{joint.mimic.joint}'
        )
        for robot in scene.robots
        for joint in robot.tree.joints
        if joint.mimic is not None
    }


def scoped(plant, element):
    """Return the scoped name of an element of a plant."""
    if element.name() == 'world':
        return WORLD
    return f'{plant.GetModelInstanceName(element.model_instance())}::{element.name()}'


def of_ours(scene, q, poses, within=0.3):
    """Return the facts of a description at the joint values and poses of a plant.

    Root links that have no pose in the description are placed as in the plant.
    """
    scene_graph = SceneGraph()
    loaded = register(scene_graph, scene)
    inspector = scene_graph.model_inspector()
    posed = dict(loaded.X_PFs)
    for robot in loaded.robots.values():
        kinematics = Kinematics(robot.tree)
        values = {}
        for joint in robot.tree.joints:
            of_plant = _value(q, f'{robot.name}::{joint.name}')
            if of_plant is not None and joint.mimic is None:
                values |= values_of_drake(robot.tree, joint.name, list(of_plant))
        row = kinematics.at_rest(values)
        root = kinematics.link_names[0]
        X_WB = robot.X_WB.GetAsMatrix4()
        if root != WORLD and loaded.frames[robot.name, root] not in posed:
            X_WB = poses[f'{robot.name}::{root}']
        X_PLs = kinematics.link_transforms(row, X_WB)
        for link, X_PL in zip(kinematics.link_names, X_PLs, strict=True):
            if (robot.name, link) in loaded.frames:
                posed[loaded.frames[robot.name, link]] = RigidTransform(X_PL)
        floating = [j for j in robot.tree.joints if j.type == 'floating']
        for link in _below(robot.tree, [j.child for j in floating]):
            X_WL = RigidTransform(poses[f'{robot.name}::{link}'])
            posed[loaded.frames[robot.name, link]] = X_WL
    context = scene_graph.CreateDefaultContext()
    for source in loaded.sources.values():
        own = {f: X for f, X in posed.items() if inspector.BelongsToSource(f, source)}
        scene_graph.get_source_pose_port(source).FixValue(context, FramePoseVector(own))
    query = scene_graph.get_query_output_port().Eval(context)
    keys, counts = {}, {}
    for id in inspector.GetAllGeometryIds(Role.kProximity):
        frame = inspector.GetFrameId(id)
        link = f'{inspector.GetOwningSourceName(id)}::{inspector.GetName(frame)}'
        link = WORLD if frame == inspector.world_frame_id() else link
        counts[link] = counts.get(link, -1) + 1
        keys[id] = (link, counts[link])
    manager = scene_graph.collision_filter_manager()
    distances = {
        frozenset((keys[pair.id_A], keys[pair.id_B])): pair.distance
        for pair in query.ComputeSignedDistancePairwiseClosestPoints(within)
    }
    return Facts(
        {key: shape_key(inspector.GetShape(id)) for id, key in keys.items()},
        {key: inspector.GetName(id) for id, key in keys.items()},
        {key: query.GetPoseInWorld(id).GetAsMatrix4() for id, key in keys.items()},
        {
            frozenset((keys[a], keys[b]))
            for a, b in combinations(keys, 2)
            if not manager.explain(a, b)
        },
        distances,
    )


def _value(q, name):
    """Return the value of a joint; pydrake gives some to the nested model of their child."""
    if name in q:
        return q[name]
    model, _, joint = name.rpartition('::')
    nested = [key for key in q if key.startswith(f'{model}::') and key.endswith(f'::{joint}')]
    return q[nested[0]] if len(nested) == 1 else None


def _below(tree, links):
    """Return links and all that joints hold below them."""
    reached = list(links)
    for link in reached:
        reached += [joint.child for joint in tree.joints if joint.parent == link]
    return reached


def differences(drake, ours, tolerance=1e-9):
    """Return what differs between two facts, as lines."""
    lines = []
    if drake.shapes.keys() != ours.shapes.keys():
        return [f'geometries: {sorted(drake.shapes.keys() ^ ours.shapes.keys())[:6]}']
    for key, shape in drake.shapes.items():
        if shape != ours.shapes[key]:
            lines.append(f'{key}: {shape} is {ours.shapes[key]}')
        if not np.allclose(drake.X_WGs[key], ours.X_WGs[key], rtol=0.0, atol=tolerance):
            lines.append(f'{key}: pose {drake.X_WGs[key][:3]} is {ours.X_WGs[key][:3]}')
    if drake.pairs != ours.pairs:
        only = [sorted(map(tuple, pair)) for pair in drake.pairs - ours.pairs]
        more = [sorted(map(tuple, pair)) for pair in ours.pairs - drake.pairs]
        lines.append(f'pairs: missing {len(only)} {only[:2]}, too many {len(more)} {more[:2]}')
    return lines


def compared(file, package_roots=(), seed=0, text='', kind=''):
    """Return the differences between a model file here and in pydrake."""
    plant = plant_of(file, package_roots, text, kind)
    scene = read_scene(text or file, kind, package_roots=package_roots)
    drake, q, poses = of_drake(*plant, np.random.default_rng(seed), mimics=mimics_of(scene))
    ours = of_ours(scene, q, poses)
    lines = differences(drake, ours)
    if drake.distances is not None:
        for pair in drake.distances.keys() & ours.distances.keys():
            if abs(drake.distances[pair] - ours.distances[pair]) > 1e-6:
                lines.append(
                    f'{sorted(pair)}: distance {drake.distances[pair]} is {ours.distances[pair]}'
                )
    return lines
