"""The table of services: name, type, and the handler that answers."""

from __future__ import annotations

from drake_geom_msgs import srv
from std_srvs.srv import Trigger

from drake_geom_ros.ros import handlers

SERVICES = (
    ('register_source', srv.RegisterSource, handlers.register_source),
    ('register_frame', srv.RegisterFrame, handlers.register_frame),
    ('register_geometry', srv.RegisterGeometry, handlers.register_geometry),
    ('assign_role', srv.AssignRole, handlers.assign_role),
    ('remove_role', srv.RemoveRole, handlers.remove_role),
    ('remove_geometry', srv.RemoveGeometry, handlers.remove_geometry),
    ('change_shape', srv.ChangeShape, handlers.change_shape),
    ('load_scene', srv.LoadScene, handlers.load_scene),
    ('save_scene', srv.SaveScene, handlers.save_scene),
    ('apply_filter', srv.ApplyFilter, handlers.apply_filter),
    ('apply_transient_filter', srv.ApplyTransientFilter, handlers.apply_transient_filter),
    ('renew_filter', srv.RenewFilter, handlers.renew_filter),
    ('remove_filter', srv.RemoveFilter, handlers.remove_filter),
    ('flatten_filters', Trigger, handlers.flatten_filters),
    ('get_filters', srv.GetFilters, handlers.get_filters),
    ('explain_filter', srv.ExplainFilter, handlers.explain_filter),
    (
        'compute_point_pair_penetration',
        srv.ComputePointPairPenetration,
        handlers.compute_point_pair_penetration,
    ),
    (
        'compute_signed_distance_pairwise',
        srv.ComputeSignedDistancePairwise,
        handlers.compute_signed_distance_pairwise,
    ),
    (
        'compute_signed_distance_pair',
        srv.ComputeSignedDistancePair,
        handlers.compute_signed_distance_pair,
    ),
    (
        'compute_signed_distance_to_point',
        srv.ComputeSignedDistanceToPoint,
        handlers.compute_signed_distance_to_point,
    ),
    (
        'find_collision_candidates',
        srv.FindCollisionCandidates,
        handlers.find_collision_candidates,
    ),
    ('has_collisions', srv.HasCollisions, handlers.has_collisions),
    ('get_pose', srv.GetPose, handlers.get_pose),
)
