"""How two pads press a can while a gripper closes: area, force and pressure by the closing width.

./run exec python examples/grasp_patch.py                      # a table
./run exec python examples/grasp_patch.py --picture patch.png  # and the last patch, drawn
"""

import argparse

import numpy as np

from drake_geom_ros.geometry import (
    AddCompliantHydroelasticProperties,
    AddRigidHydroelasticProperties,
    Box,
    Cylinder,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    ProximityProperties,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform

RADIUS, HEIGHT = 0.033, 0.12  # of the can [m]
PAD = (0.01, 0.02, 0.04)  # thickness, width and height [m]
MODULUS = 1e6  # of the pads [Pa]
SQUEEZES = (0.0, 0.0005, 0.001, 0.0015, 0.002, 0.003)  # of each pad [m]


class Grasp:
    """A rigid can between two compliant pads."""

    def __init__(self):
        self._scene = SceneGraph()
        source = self._scene.RegisterSource('gripper')
        rigid, soft = ProximityProperties(), ProximityProperties()
        AddRigidHydroelasticProperties(0.002, rigid)
        AddCompliantHydroelasticProperties(0.005, MODULUS, soft)
        can = GeometryInstance(RigidTransform(), Cylinder(RADIUS, HEIGHT), 'can')
        can.set_proximity_properties(rigid)
        self._scene.RegisterAnchoredGeometry(source, can)
        self._fingers = []
        for name in ('left', 'right'):
            finger = self._scene.RegisterFrame(source, GeometryFrame(name))
            pad = GeometryInstance(RigidTransform(), Box(*PAD), 'pad')
            pad.set_proximity_properties(soft)
            self._scene.RegisterGeometry(source, finger, pad)
            self._fingers.append(finger)
        self._context = self._scene.CreateDefaultContext()
        self._port = self._scene.get_source_pose_port(source)

    def patches(self, squeeze):
        """Return the contact surfaces where each pad is pressed in by ``squeeze`` [m]."""
        x = RADIUS + 0.5 * PAD[0] - squeeze
        poses = {
            finger: RigidTransform([side * x, 0.0, 0.01])
            for finger, side in zip(self._fingers, (-1, 1), strict=True)
        }
        self._port.FixValue(self._context, FramePoseVector(poses))
        query = self._scene.get_query_output_port().Eval(self._context)
        return query.ComputeContactSurfaces()


def draw(patch, path):
    """Draw a patch as the pad sees it, coloured by pressure."""
    import matplotlib

    matplotlib.use('Agg')
    from matplotlib import pyplot
    from matplotlib.collections import PolyCollection

    points, pressures, ends = patch.polygon_arrays()
    parts = np.split(np.arange(len(points)), ends[:-1])
    figure, axes = pyplot.subplots(figsize=(4.2, 5.2), layout='constrained')
    polygons = PolyCollection(
        [1e3 * points[part][:, 1:] for part in parts],
        array=np.array([pressures[part].mean() for part in parts]) / 1e3,
        cmap='viridis',
        edgecolors='face',
    )
    axes.add_collection(polygons)
    axes.autoscale()
    axes.set(aspect='equal', xlabel='y [mm]', ylabel='z [mm]', title='A pad on a can')
    figure.colorbar(polygons, label='pressure [kPa]')
    figure.savefig(path, dpi=110)


def main():
    """Print the table, and draw the last patch."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--picture', help='where to write a picture of the last patch')
    arguments = parser.parse_args()
    grasp = Grasp()
    print('opening [mm]   area [mm2]   force [N]   mean pressure [kPa]')
    for squeeze in SQUEEZES:
        patches = grasp.patches(squeeze)
        area = patches.areas.sum() / 2
        force = np.linalg.norm(patches.forces_on_M_W, axis=1).sum() / 2
        mean = force / area / 1e3 if area else 0.0
        opening = 2e3 * (RADIUS - squeeze)
        print(f'{opening:12.1f} {1e6 * area:12.1f} {force:11.2f} {mean:21.1f}')
    if arguments.picture:
        draw(patches[0], arguments.picture)


if __name__ == '__main__':
    main()
