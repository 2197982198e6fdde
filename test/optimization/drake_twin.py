"""The planar arm as a plant of pydrake, with its constraints."""

from optimization.conftest import URDF
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.systems.framework import DiagramBuilder


class DrakeTwin:
    """The plant, its context, and ids of geometries by name."""

    def __init__(self):
        builder = DiagramBuilder()
        self.plant, self.scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
        inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        masses = f'<inertial><mass value="1"/>{inertia}</inertial>'
        text = URDF
        for link in ('upper', 'lower', 'tip'):
            text = text.replace(f'<link name="{link}">', f'<link name="{link}">{masses}')
        Parser(self.plant).AddModelsFromString(text, 'urdf')
        world, friction = self.plant.world_body(), CoulombFriction(1.0, 1.0)
        self.plant.WeldFrames(self.plant.world_frame(), self.plant.GetFrameByName('base'))
        things = {
            'box': (RigidTransform([0.7, 0.6, 0]), Box(0.3, 0.2, 0.4)),
            'ball': (RigidTransform([0.6, -0.7, 0.1]), Sphere(0.15)),
        }
        for name, (X_WG, shape) in things.items():
            self.plant.RegisterCollisionGeometry(world, X_WG, shape, name, friction)
        self.plant.Finalize()
        self.diagram = builder.Build()
        self.context = self.diagram.CreateDefaultContext()
        self.plant_context = self.plant.GetMyMutableContextFromRoot(self.context)
        inspector = self.scene_graph.model_inspector()
        self.pairs = len(inspector.GetCollisionCandidates())
        self.geometries = {
            inspector.GetName(id).split('::')[-1]: id for id in inspector.GetAllGeometryIds()
        }
