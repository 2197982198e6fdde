"""Register a scene, pose it, and ask about it, with the calls of pydrake.

Replace ``drake_geom_ros`` by ``pydrake`` in the two imports below, and it runs under pydrake and
prints the same.

A gripper of two fingers, frames nested in a hand, reaches for a ball above a table. Fingers and
palm are next to each other all the time, so their pairs are filtered; while the ball is held, the
pairs of fingers and ball are filtered too, for just as long.
"""

from drake_geom_ros.geometry import (
    Box,
    CollisionFilterDeclaration,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform


def register(scene_graph, source_id, frame_id, shape, p_FG, name):
    """Register a shape that takes part in proximity queries; return its id."""
    instance = GeometryInstance(RigidTransform(p_FG), shape, name)
    instance.set_proximity_properties(ProximityProperties())
    return scene_graph.RegisterGeometry(source_id, frame_id, instance)


def build():
    """Return the scene graph, its two sources with their frames, and its geometries by name."""
    scene_graph = SceneGraph()
    world = scene_graph.world_frame_id()
    robot = scene_graph.RegisterSource('robot')
    things = scene_graph.RegisterSource('things')

    hand = scene_graph.RegisterFrame(robot, GeometryFrame('hand'))
    left = scene_graph.RegisterFrame(robot, hand, GeometryFrame('left'))
    right = scene_graph.RegisterFrame(robot, hand, GeometryFrame('right'))
    toy = scene_graph.RegisterFrame(things, GeometryFrame('toy'))

    finger = Box(0.02, 0.02, 0.1)
    ids = {
        'palm': register(scene_graph, robot, hand, Box(0.2, 0.05, 0.04), [0, 0, 0.07], 'palm'),
        'left finger': register(scene_graph, robot, left, finger, [0, 0, 0], 'finger'),
        'right finger': register(scene_graph, robot, right, finger, [0, 0, 0], 'finger'),
        'ball': register(scene_graph, things, toy, Sphere(0.03), [0, 0, 0], 'ball'),
        'table': register(scene_graph, things, world, Box(1, 1, 0.1), [0, 0, -0.05], 'table'),
    }
    # Neighbours in the hand never count.
    fingers_and_palm = GeometrySet([hand, left, right])
    scene_graph.collision_filter_manager().Apply(
        CollisionFilterDeclaration().ExcludeWithin(fingers_and_palm)
    )
    return scene_graph, {robot: (hand, left, right), things: (toy,)}, ids


def pose(scene_graph, frames_of, context, opening):
    """Pose all frames: the hand above the ball, its fingers ``opening`` [m] apart."""
    positions = {'hand': [0, 0, 0.06], 'toy': [0, 0, 0.05]}
    positions['left'] = [-0.5 * opening - 0.01, 0, 0]
    positions['right'] = [0.5 * opening + 0.01, 0, 0]
    for source_id, frames in frames_of.items():
        poses = FramePoseVector()
        for frame_id in frames:
            name = scene_graph.model_inspector().GetName(frame_id)
            poses.set_value(frame_id, RigidTransform(positions[name]))
        scene_graph.get_source_pose_port(source_id).FixValue(context, poses)


def report(query_object, ids):
    """Print what touches, and how far the rest is apart."""
    name_of = {id: name for name, id in ids.items()}
    order = list(ids.values())

    def by_order(pair):
        return sorted(order.index(id) for id in (pair.id_A, pair.id_B))

    def names(pair):
        return ' and '.join(name_of[order[k]] for k in by_order(pair))

    for pair in sorted(query_object.ComputePointPairPenetration(), key=by_order):
        print(f'  {names(pair)} overlap by {pair.depth:.4f} m')
    distances = query_object.ComputeSignedDistancePairwiseClosestPoints(max_distance=0.04)
    for pair in sorted(distances, key=by_order):
        if pair.distance > 0:
            print(f'  {names(pair)} are {pair.distance:.4f} m apart')
    print(f'  any collision: {query_object.HasCollisions()}')


def main():
    """Show the open hand, the closed one, and the closed one while it holds the ball."""
    scene_graph, frames_of, ids = build()
    inspector = scene_graph.model_inspector()
    print(f'{inspector.num_geometries()} geometries, {inspector.num_frames()} frames')
    print(f'{len(inspector.GetCollisionCandidates())} pairs to look at')
    context = scene_graph.CreateDefaultContext()
    query_object = scene_graph.get_query_output_port().Eval

    print('open:')
    pose(scene_graph, frames_of, context, opening=0.08)
    report(query_object(context), ids)

    print('closed:')
    pose(scene_graph, frames_of, context, opening=0.056)
    report(query_object(context), ids)

    print('holding:')
    manager = scene_graph.collision_filter_manager(context)
    fingers = GeometrySet([ids['left finger'], ids['right finger']])
    held = manager.ApplyTransient(
        CollisionFilterDeclaration().ExcludeBetween(fingers, GeometrySet([ids['ball']]))
    )
    report(query_object(context), ids)

    print('let go:')
    print(f'  filter removed: {manager.RemoveDeclaration(held)}')
    report(query_object(context), ids)
    p_WBall = query_object(context).GetPoseInWorld(ids['ball']).translation()
    print(f'  the ball is at {[round(float(x), 3) for x in p_WBall]}')


if __name__ == '__main__':
    main()
