"""The table of services: name, type, and the handler that answers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from drake_geom_msgs import srv
from std_srvs.srv import Trigger

from drake_geom_ros.live.scene.live_scene import LiveScene
from drake_geom_ros.live.services import (
    files,
    filters,
    motions,
    obstacles,
    proximity_rules,
    queries,
    scene,
    shapes,
    states,
)
from drake_geom_ros.live.watching.trajectory_watch import TrajectoryWatch
from drake_geom_ros.ros.services import cameras

Handler = Callable[[LiveScene, Any, Any], None]

# Services that change the scene, prepared first if the scene is large: beside the main thread,
# which ends leases, and apart from those that load for long.
CHANGES: tuple[tuple[str, Any, Handler], ...] = (
    ('register_source', srv.RegisterSource, scene.register_source),
    ('attach', srv.Attach, scene.attach),
    ('detach', srv.Detach, scene.detach),
    ('apply_filter', srv.ApplyFilter, filters.apply_filter),
    ('apply_transient_filter', srv.ApplyTransientFilter, filters.apply_transient_filter),
    ('renew_filter', srv.RenewFilter, filters.renew_filter),
    ('remove_filter', srv.RemoveFilter, filters.remove_filter),
    ('flatten_filters', Trigger, filters.flatten_filters),
    ('add_proximity_rule', srv.AddProximityRule, proximity_rules.add_proximity_rule),
    ('remove_proximity_rule', srv.RemoveProximityRule, proximity_rules.remove_proximity_rule),
    ('acknowledge_rule', srv.AcknowledgeRule, proximity_rules.acknowledge_rule),
    ('add_camera', srv.AddCamera, cameras.add_camera),
    ('remove_camera', srv.RemoveCamera, cameras.remove_camera),
)

# Services that may read files and compile kernels, for seconds: beside cycle and queries.
# (Measured with two arms at 100 Hz and a solid mesh whose kernels were not compiled yet: in the
# thread of the queries has_collisions waited 98 s, in one of their own 0.4 s; cycles do not
# notice which, with or without load.)
LOADING: tuple[tuple[str, Any, Handler], ...] = (
    ('register_frame', srv.RegisterFrame, scene.register_frame),
    ('remove_role', srv.RemoveRole, scene.remove_role),
    ('remove_geometry', srv.RemoveGeometry, scene.remove_geometry),
    ('remove_source', srv.RemoveSource, scene.remove_source),
    ('register_geometry', srv.RegisterGeometry, shapes.register_geometry),
    ('register_geometries', srv.RegisterGeometries, shapes.register_geometries),
    ('assign_role', srv.AssignRole, shapes.assign_role),
    ('change_shape', srv.ChangeShape, shapes.change_shape),
    ('load_scene', srv.LoadScene, files.load_scene),
    ('save_scene', srv.SaveScene, files.save_scene),
    ('add_obstacle_source', srv.AddObstacleSource, obstacles.add_obstacle_source),
    ('remove_obstacle_source', srv.RemoveObstacleSource, obstacles.remove_obstacle_source),
    ('clear_obstacles', srv.ClearObstacles, obstacles.clear_obstacles),
    ('load_obstacles', srv.LoadObstacles, obstacles.load_obstacles),
    ('save_obstacles', srv.SaveObstacles, obstacles.save_obstacles),
)

# Queries: beside the cycle.
BESIDE: tuple[tuple[str, Any, Handler], ...] = (
    ('get_filters', srv.GetFilters, queries.get_filters),
    ('explain_filter', srv.ExplainFilter, queries.explain_filter),
    (
        'compute_point_pair_penetration',
        srv.ComputePointPairPenetration,
        queries.compute_point_pair_penetration,
    ),
    (
        'compute_signed_distance_pairwise',
        srv.ComputeSignedDistancePairwise,
        queries.compute_signed_distance_pairwise,
    ),
    (
        'compute_signed_distance_pair',
        srv.ComputeSignedDistancePair,
        queries.compute_signed_distance_pair,
    ),
    (
        'compute_signed_distance_to_point',
        srv.ComputeSignedDistanceToPoint,
        queries.compute_signed_distance_to_point,
    ),
    (
        'find_collision_candidates',
        srv.FindCollisionCandidates,
        queries.find_collision_candidates,
    ),
    ('has_collisions', srv.HasCollisions, queries.has_collisions),
    ('get_pose', srv.GetPose, queries.get_pose),
    ('get_pose_ages', srv.GetPoseAges, queries.get_pose_ages),
    ('get_joint_positions', srv.GetJointPositions, queries.get_joint_positions),
    ('list_cameras', srv.ListCameras, cameras.list_cameras),
    (
        'list_obstacle_sources',
        srv.ListObstacleSources,
        obstacles.list_obstacle_sources,
    ),
    (
        'list_proximity_rules',
        srv.ListProximityRules,
        proximity_rules.list_proximity_rules,
    ),
)

# Images: beside all of these, for the first one compiles for seconds.
IMAGES: tuple[tuple[str, Any, Handler], ...] = (
    ('render_image', srv.RenderImage, cameras.render_image),
)

# Queries of many states, or of surfaces of fine meshes: for seconds, beside all these.
PLANNING: tuple[tuple[str, Any, Handler], ...] = (
    ('evaluate_states', srv.EvaluateStates, states.evaluate_states),
    (
        'compute_contact_surfaces',
        srv.ComputeContactSurfaces,
        queries.compute_contact_surfaces,
    ),
)

# Proofs of motions, for as long as they take: beside all of these.
MOTIONS: tuple[tuple[str, Any, Handler], ...] = (
    ('check_motion', srv.CheckMotion, motions.check_motion),
)

# Running trajectories, in the thread that judges them again.
WATCHING: tuple[tuple[str, Any, Callable[[TrajectoryWatch, Any, Any], None]], ...] = (
    ('watch_trajectory', srv.WatchTrajectory, TrajectoryWatch.begin),
    ('unwatch_trajectory', srv.UnwatchTrajectory, TrajectoryWatch.end),
)

# Of MoveIt's type, whose package may be missing: opened with the parameter use_planning_scene.
STATE_VALIDITY = 'check_state_validity'

SERVICES = (*CHANGES, *LOADING, *BESIDE, *IMAGES, *PLANNING, *MOTIONS, *WATCHING)
