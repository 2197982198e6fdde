"""Prove a trajectory before it runs, and its rest again whenever the scene changes.

    ./run exec python examples/check_before_execute.py

Ruckig (PyPI: ruckig) plans a way with limited jerk. What a controller would get, points with
velocities and accelerations, is proved clear along the quintics that it follows. While it runs, a
box is pushed into its way, a centimetre each 20 ms: at each step the rest is proved anew, from
where the arm is by then, until it is not clear any more, which leaves the time to stop.
"""

import numpy as np
from ruckig import InputParameter, Ruckig, Trajectory

from drake_geom_ros.batch import Joints, check_trajectory
from drake_geom_ros.geometry import FramePoseVector, SceneGraph
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.trajectories import JointTrajectory

PANDA = 'package://example-robot-data/robots/panda_description'
SCENE = f"""
sources: [arm, things]
robots:
- name: arm
  urdf: {PANDA}/urdf/panda_collision.urdf
  srdf: {PANDA}/srdf/panda.srdf
  pose: {{}}
  configuration: {{panda_joint1: -1.0, panda_joint2: 0.3, panda_joint3: 0, panda_joint4: -1.8,
    panda_joint5: 0, panda_joint6: 2.1, panda_joint7: 0.785, panda_finger_joint1: 0.02}}
frames:
- {{name: box, source: things, pose: {{position: [0.55, 1.1, 0.5]}}}}
geometries:
- {{name: box, source: things, frame: box, shape: {{type: box, size: [0.2, 0.2, 0.2]}}}}
"""
NAMES = [f'arm::panda_joint{k}' for k in range(1, 8)]
START = [-1.0, 0.3, 0.0, -1.8, 0.0, 2.1, 0.785]  # [rad], as the scene has it
GOAL = [1.0, 0.3, 0.0, -1.8, 0.0, 2.1, 0.785]
CLEARANCE = 0.02  # [m]
PERIOD, STEP = 0.05, 0.02  # [s] between points of a message, and between steps of the box
SPEED = 0.5  # [m/s] of the box, against y


def planned():
    """Return a trajectory of Ruckig from the start to the goal."""
    wanted = InputParameter(len(NAMES))
    wanted.current_position, wanted.target_position = START, GOAL
    wanted.max_velocity = [1.5] * len(NAMES)  # [rad/s]
    wanted.max_acceleration = [5.0] * len(NAMES)
    wanted.max_jerk = [50.0] * len(NAMES)
    trajectory = Trajectory(len(NAMES))
    Ruckig(len(NAMES)).calculate(wanted, trajectory)
    return trajectory


def message(trajectory, begin):
    """Return the points from a time [s] on, as a controller gets them."""
    count = max(2, int(np.ceil((trajectory.duration - begin) / PERIOD)) + 1)
    times = np.linspace(begin, trajectory.duration, count)
    points = [trajectory.at_time(time) for time in times]
    return JointTrajectory(times, *np.swapaxes(points, 0, 1)[:3])


def main():
    """Prove, run and watch."""
    scene_graph = SceneGraph()
    loaded = load_scene(SCENE, scene_graph)
    joints, box = Joints.of(loaded, NAMES), loaded.frames['things', 'box']
    context = scene_graph.CreateDefaultContext()
    trajectory = planned()

    def check(begin):
        return check_trajectory(context, joints, message(trajectory, begin), CLEARANCE)

    before = check(0.0)
    print(f'{trajectory.duration:.2f} s, before it runs: {before.outcome}')
    for now in np.arange(0.0, trajectory.duration, STEP):
        X_WB = RigidTransform([0.55, 1.1 - SPEED * now, 0.5])
        context.UpdateFramePoses(FramePoseVector({box: X_WB}))
        rest = check(now)
        if rest.outcome != 'clear':
            pair = ' and '.join(loaded.name_of(id) for id in (rest.id_A, rest.id_B))
            print(f'at {now:.2f} s the rest is not clear: {rest.outcome} of {pair}')
            print(f'at {rest.last_free:.2f} s it is nearer than {CLEARANCE} m: time to stop')
            return
    print('it ran to its end')


if __name__ == '__main__':
    main()
