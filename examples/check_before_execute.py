"""Prove a trajectory before it runs, and its rest again whenever the scene changes.

    ./run exec python examples/check_before_execute.py
    ./run exec python examples/check_before_execute.py --server /scene_graph

Ruckig (PyPI: ruckig) plans a way with limited jerk. What a controller would get, points with
velocities and accelerations, is proved clear along the quintics that it follows. While it runs, a
box is pushed into its way, a centimetre each 20 ms: at each step the rest is proved anew, from
where the arm is by then, until it is not clear any more, which leaves the time to stop.

With ``--server`` a running node (parameter ``use_joint_states``) watches the trajectory instead,
and judges its rest whenever the box has moved.
"""

import argparse
import time

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
    panda_joint5: 0, panda_joint6: 2.1, panda_joint7: 0.785}}
  held_joints: {{panda_finger_joint1: 0.02}}
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


def watch_by_node(server):
    """Let a node check and watch the trajectory, while the arm follows it and the box moves."""
    from sensor_msgs.msg import JointState

    from drake_geom_ros.client import SceneGraphClient

    trajectory = planned()
    points = message(trajectory, 0.0)
    way = {'joint_names': NAMES, 'path': points.positions, 'times': points.times}
    way |= {'velocities': points.velocities, 'accelerations': points.accelerations}
    with SceneGraphClient(server) as client:
        client.call('load_scene', text=SCENE, replace=True)
        states = client.node.create_publisher(JointState, '/joint_states', 10)
        client.wait_for(states.get_subscription_count, 'a node with use_joint_states')
        clock = client.node.get_clock()

        def follow(elapsed):
            """Report the joints where the trajectory has them, and push the box."""
            report = JointState(name=NAMES, position=trajectory.at_time(elapsed)[0])
            report.header.stamp = clock.now().to_msg()
            states.publish(report)
            X_WB = RigidTransform([0.55, 1.1 - SPEED * elapsed, 0.5])
            client.publish_poses({'things::box': X_WB})

        def heard():
            follow(0.0)
            return client.joint_states()[NAMES[0]].age < 1.0

        client.wait_for(heard, 'the node to hear of the joints')
        before = client.check_motion(**way, min_distance=CLEARANCE, allow_stale=True)
        print(f'{trajectory.duration:.2f} s, before it runs: {before.outcome}')
        begin = clock.now()
        name = client.watch_trajectory(
            **way, start=begin.nanoseconds / 1e9, min_distance=CLEARANCE, time_budget=0.05
        )
        elapsed = 0.0
        while elapsed < trajectory.duration:
            follow(elapsed)
            state = client.trajectory_states().get(name)
            if state is not None and state.outcome == 'contact':
                print(f'at {elapsed:.2f} s the rest is not clear: contact of {state.names}')
                print(f'at {state.last_free:.2f} s it is nearer than {CLEARANCE} m: time to stop')
                client.unwatch_trajectory(name)
                return
            time.sleep(STEP)
            elapsed = (clock.now() - begin).nanoseconds / 1e9
        print('it ran to its end')


def main():
    """Prove, run and watch."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--server', help='name of a running node that watches, /scene_graph')
    server = parser.parse_args().server
    if server:
        watch_by_node(server)
    else:
        watch_here()


def watch_here():
    """Prove the trajectory and its rest in this process."""
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
