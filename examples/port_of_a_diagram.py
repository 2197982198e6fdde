"""A pydrake script with a Diagram, ported: load a robot, set its joints, print the closest pair.

The comments show the lines of pydrake that were there.
"""

from drake_geom_ros.geometry import FramePoseVector, SceneGraph
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.trajectories.kinematics import Kinematics

# builder = DiagramBuilder()
# plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
# Parser(plant).AddModels('cell.dmd.yaml')
# plant.Finalize()
# diagram = builder.Build()
scene_graph = SceneGraph()
loaded = load_scene('examples/ur5_cell/cell.yaml', scene_graph)
(robot,) = loaded.robots.values()
kinematics = Kinematics(str(robot.urdf))

# context = diagram.CreateDefaultContext()
# plant.SetPositions(plant.GetMyContextFromRoot(context), q)
context = scene_graph.CreateDefaultContext()
q = [0.0, -1.2, 1.6, -2.0, -1.57, 0.0]
X_WLs = kinematics.link_transforms(q, robot.X_WB.GetAsMatrix4())
poses = FramePoseVector()
for name, X_WL in zip(kinematics.link_names, X_WLs, strict=True):
    if (robot.name, name) in loaded.frames:
        poses.set_value(loaded.frames[robot.name, name], RigidTransform(X_WL))
scene_graph.get_source_pose_port(loaded.sources[robot.name]).FixValue(context, poses)

# query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
query = scene_graph.get_query_output_port().Eval(context)
pair = min(query.ComputeSignedDistancePairwiseClosestPoints(), key=lambda pair: pair.distance)
names = {id: '/'.join(key) for key, id in loaded.geometries.items()}
print(f'{pair.distance:.4f} m between {names[pair.id_A]} and {names[pair.id_B]}')
