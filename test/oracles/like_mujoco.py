"""Comparison of a loaded model with the one that MuJoCo compiles from the same MJCF."""

from itertools import combinations

import numpy as np

from drake_geom_ros.geometry import FramePoseVector, Role, SceneGraph
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files import WORLD, register
from drake_geom_ros.trajectories.kinematics import Kinematics

FAR = 1e3  # [m]: geometries within this margin make contacts
# MuJoCo takes frames within 1e-7 or so of their body for the body itself (``geom_sameframe``).


def posed(model, rng):
    """Return MuJoCo's data at random joint values, and these values by our names."""
    import mujoco

    data = mujoco.MjData(model)
    values = {}
    for id in range(model.njnt):
        name = model.joint(id).name or f'joint_{id}'
        start, kind = model.jnt_qposadr[id], model.jnt_type[id]
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            data.qpos[start : start + 3] += rng.uniform(-0.2, 0.2, 3)
        elif kind == mujoco.mjtJoint.mjJNT_BALL:
            rpy = rng.uniform(-1, 1, 3)
            X = RigidTransform(RollPitchYaw(rpy).ToRotationMatrix(), [0, 0, 0])
            x, y, z, w = X.ToArray()[3:]
            data.qpos[start : start + 4] = w, x, y, z
            parts = (f'{name}/{angle}' for angle in ('roll', 'pitch', 'yaw'))
            values |= dict(zip(parts, rpy, strict=True))
        else:
            low, high = model.jnt_range[id] if model.jnt_limited[id] else (-1.0, 1.0)
            data.qpos[start] = values[name] = rng.uniform(low, high)
    mujoco.mj_kinematics(model, data)
    return data, values


def pairs_of(model, ids):
    """Return the pairs of geometries that MuJoCo makes contacts of, however far apart."""
    import mujoco

    kept = [each.copy() for each in (model.geom_margin, model.pair_margin, model.body_margin)]
    flags = int(model.opt.disableflags)
    model.opt.disableflags = flags & int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT)
    for each in (model.geom_margin, model.pair_margin, model.body_margin):
        each[:] = FAR
    # Filters do not depend on shapes, and of two boxes MuJoCo makes no contacts so far apart.
    types = model.geom_type.copy()
    model.geom_type[types != mujoco.mjtGeom.mjGEOM_PLANE] = mujoco.mjtGeom.mjGEOM_SPHERE
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    assert not any(warning.number for warning in data.warning)
    found = {frozenset((int(c.geom[0]), int(c.geom[1]))) for c in data.contact}
    model.opt.disableflags, model.geom_type[:] = flags, types
    model.geom_margin[:], model.pair_margin[:], model.body_margin[:] = kept
    return {pair for pair in found if pair <= set(ids)}


def compared(model, scene, seed=0):
    """Return what differs between a compiled model and the description of it, as lines."""
    import mujoco

    data, values = posed(model, np.random.default_rng(seed))
    scene_graph = SceneGraph()
    loaded = register(scene_graph, scene)
    (robot,) = loaded.robots.values()
    kinematics = Kinematics(robot.tree)
    assert set(values) == {n for n in kinematics.joint_names if n not in _floating(robot.tree)}
    X_WLs = kinematics.link_transforms(kinematics.at_rest(values))
    poses = {}
    for link, X_WL in zip(kinematics.link_names, X_WLs, strict=True):
        if link != WORLD:
            poses[link] = RigidTransform(X_WL)
    free = [joint.child for joint in robot.tree.joints if joint.type == 'floating']
    for id in range(1, model.nbody):
        link = robot.tree.links[id]
        if link in free or any(link in _below(robot.tree, root) for root in free):
            w, x, y, z = data.xquat[id]
            poses[link] = RigidTransform.FromArray([*data.xpos[id], x, y, z, w])
    context = scene_graph.CreateDefaultContext()
    vector = FramePoseVector({loaded.frames[robot.name, link]: X for link, X in poses.items()})
    scene_graph.get_source_pose_port(loaded.sources[robot.name]).FixValue(context, vector)
    query = scene_graph.get_query_output_port().Eval(context)
    inspector = scene_graph.model_inspector()
    paired = {*model.pair_geom1.tolist(), *model.pair_geom2.tolist()}
    ids = [
        g
        for g in range(model.ngeom)
        if model.geom_contype[g] or model.geom_conaffinity[g] or g in paired
    ]
    ours = [*inspector.GetAllGeometryIds(Role.kProximity)]
    if len(ids) != len(ours):
        return [f'{len(ids)} geometries are {len(ours)}']
    lines = []
    for id, geometry in zip(ids, ours, strict=True):
        X_WG = query.GetPoseInWorld(geometry).GetAsMatrix4()
        if not np.allclose(X_WG[:3, 3], data.geom_xpos[id], rtol=0, atol=1e-6) or not np.allclose(
            X_WG[:3, :3].ravel(), data.geom_xmat[id], rtol=0, atol=1e-6
        ):
            lines.append(f'{inspector.GetName(geometry)}: {X_WG[:3, 3]} {data.geom_xpos[id]}')
        if (named := model.geom(id).name) and inspector.GetName(geometry) != named:
            lines.append(f'{named} is {inspector.GetName(geometry)}')
    manager = scene_graph.collision_filter_manager()
    index = dict(zip(ours, ids, strict=True))
    pairs = {
        frozenset((index[a], index[b]))
        for a, b in combinations(ours, 2)
        if not manager.explain(a, b)
    }
    truth = pairs_of(model, ids)
    # MuJoCo makes no contacts of two planes, nor of two bodies without degrees of freedom, one of
    # which may be posed by a program (mocap).
    still = {
        frozenset(pair)
        for pair in combinations(ids, 2)
        if all(
            model.geom_type[g] == mujoco.mjtGeom.mjGEOM_PLANE
            or model.body_dofnum[model.body_weldid[model.geom_bodyid[g]]] == 0
            for g in pair
        )
    }
    if pairs - still != truth - still:
        lines.append(f'pairs: missing {truth - pairs - still}, too many {pairs - truth - still}')
    where = dict(zip(ids, ours, strict=True))
    fromto = np.zeros(6)
    for pair in sorted(map(sorted, truth & pairs))[:40]:
        kinds = {int(model.geom_type[g]) for g in pair}
        if kinds & {0, 1}:  # MuJoCo has no distance of planes and of height fields
            continue
        distance = mujoco.mj_geomDistance(model, data, *pair, 10.0, fromto)
        here = query.ComputeSignedDistancePairClosestPoints(*(where[g] for g in pair))
        if 0.0 < distance < 10.0 and abs(here.distance - distance) > 1e-4:
            lines.append(
                f'{[model.geom(g).name for g in pair]} {kinds}: {distance} {here.distance}'
            )
    return lines


def _floating(tree):
    floating = [joint for joint in tree.joints if joint.type == 'floating']
    parts = ('x', 'y', 'z', 'yaw', 'pitch', 'roll')
    return {f'{joint.name}/{part}' for joint in floating for part in parts}


def _below(tree, link):
    reached = [link]
    for each in reached:
        reached += [joint.child for joint in tree.joints if joint.parent == each]
    return reached
