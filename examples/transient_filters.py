"""A history of collision filters, with the calls of pydrake.

Replace ``drake_geom_ros`` by ``pydrake`` in the two imports below, and it runs under pydrake and
prints the same.

Five balls in a row, each overlapping the next: four contacts. Persistent filters take some away;
transient ones, each made by somebody who knows nothing of the others, come and go on top of them.
"""

from drake_geom_ros.geometry import (
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


def build():
    """Return the scene graph, the frames and the balls."""
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource('balls')
    frames, balls = [], []
    for k in range(5):
        frame = scene_graph.RegisterFrame(source, GeometryFrame(f'frame_{k}'))
        instance = GeometryInstance(RigidTransform(), Sphere(0.6), f'ball_{k}')
        instance.set_proximity_properties(ProximityProperties())
        balls.append(scene_graph.RegisterGeometry(source, frame, instance))
        frames.append(frame)
    return scene_graph, source, frames, balls


def main():
    """Print the contacts after each change of the filters."""
    scene_graph, source, frames, balls = build()
    context = scene_graph.CreateDefaultContext()
    poses = FramePoseVector()
    for k, frame in enumerate(frames):
        poses.set_value(frame, RigidTransform([float(k), 0.0, 0.0]))
    scene_graph.get_source_pose_port(source).FixValue(context, poses)
    query_object = scene_graph.get_query_output_port().Eval(context)
    manager = scene_graph.collision_filter_manager(context)
    numbers = {ball: k for k, ball in enumerate(balls)}

    def show(what):
        contacts = query_object.ComputePointPairPenetration()
        pairs = sorted(sorted((numbers[c.id_A], numbers[c.id_B])) for c in contacts)
        depths = {round(c.depth, 9) for c in contacts}
        print(f'{what:38} {pairs} depths {sorted(depths)}')

    def declaration(method, *members):
        sets = [GeometrySet([balls[k] for k in group]) for group in members]
        return getattr(CollisionFilterDeclaration(), method)(*sets)

    show('at first')
    manager.Apply(declaration('ExcludeWithin', [0, 1, 2]))
    show('persistent: nothing within 0, 1, 2')
    first = manager.ApplyTransient(declaration('ExcludeBetween', [3], [2, 4]))
    show('transient 1: 3 touches nobody')
    second = manager.ApplyTransient(declaration('AllowBetween', [2], [1, 3]))
    show('transient 2: 2 touches 1 and 3')
    print('history:', manager.has_transient_history())
    manager.RemoveDeclaration(first)
    show('transient 1 removed')
    print('active:', manager.IsActive(first), manager.IsActive(second))
    try:
        manager.Apply(declaration('AllowWithin', [0, 1, 2]))
    except RuntimeError:
        print('persistent filters wait until the history is gone')
    manager.RemoveDeclaration(second)
    show('transient 2 removed')
    manager.Apply(declaration('AllowWithin', [0, 1, 2]))
    show('persistent: all allowed again')


if __name__ == '__main__':
    main()
