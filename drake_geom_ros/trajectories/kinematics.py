"""Forward kinematics of a URDF tree, vectorised over joints and over configurations."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.geometry.joint_trees import JointKind, JointTree
from drake_geom_ros.trajectories.pose_matrices import matrices_of_poses, poses_of_matrices

_KINDS = {
    'revolute': JointKind.REVOLUTE,
    'continuous': JointKind.REVOLUTE,
    'prismatic': JointKind.PRISMATIC,
}
_MOVING = tuple(_KINDS)


class Kinematics:
    """The links of a robot over its independent joints; mimic joints follow their leader.

    ``joined_links`` are the two links of each joint, fixed ones too; ``tree`` is all that a pose
    of a link depends on, as arrays.

    The URDF is parsed by yourdfpy, which keeps every element and loads no mesh when told so. Its
    own forward kinematics walks a graph in Python, one configuration at a time (milliseconds for
    a dozen links), so that of ``JointTree`` is taken.
    """

    def __init__(self, urdf_path: str):
        """Read the URDF at a path; raises ValueError for what is not a tree of simple joints.

        Raises GeometryError where yourdfpy is not installed.
        """
        robot = _parsed(urdf_path)
        joints = _parents_first(robot)
        leader = _mimicked(robot, urdf_path)
        independent = [j for j in robot.joints if leader[j.name][0] == j.name]
        limits = [_limits(j) for j in independent]

        self.name: str = robot.name
        self.joint_names = tuple(j.name for j in independent)
        self.lower, self.upper, self.max_speed = np.array(limits, dtype=float).reshape(-1, 3).T
        self.link_names = (_root(robot), *(j.child for j in joints))
        self.joined_links = tuple((j.parent, j.child) for j in joints)

        self.tree = JointTree(
            leaders=np.array([self._leader(leader[j.name][0]) for j in joints], dtype=np.int64),
            multipliers=np.array([leader[j.name][1] for j in joints], dtype=float),
            offsets=np.array([leader[j.name][2] for j in joints], dtype=float),
            kinds=np.array([_KINDS.get(j.type, JointKind.FIXED) for j in joints], dtype=np.int64),
            axes=np.array([_unit_axis(j) for j in joints], dtype=float).reshape(-1, 3),
            X_PJs=_poses_in_parents(joints),
            parents=np.array([self.link_names.index(j.parent) for j in joints], dtype=np.int64),
            children=np.arange(1, len(joints) + 1),
        )

    def _leader(self, name: str) -> int:
        """Return which independent joint a name is of; -1 for the empty one of a fixed joint."""
        return self.joint_names.index(name) if name else -1

    def link_transforms(self, q: ArrayLike, X_WB: ArrayLike | None = None) -> NDArray[np.float64]:
        """Return X_WL of every link (..., links, 4, 4) for configurations q (..., joints).

        Positions in [m] and angles in [rad], in the order of ``joint_names``; links in the order
        of ``link_names``, the base link B first. ``X_WB`` (4, 4) places it (default: identity).
        """
        q = np.asarray(q, dtype=float)
        if q.shape[-1:] != (len(self.joint_names),):
            raise ValueError(
                f'{self.name}: q must have shape (..., {len(self.joint_names)}), one value each '
                f'for {", ".join(self.joint_names)}; got {q.shape}'
            )
        base = poses_of_matrices(np.eye(4) if X_WB is None else X_WB)
        rows = q.reshape(math.prod(q.shape[:-1]), q.shape[-1])
        X_WLs = self.tree.link_poses(rows, base)
        return matrices_of_poses(X_WLs.reshape(*q.shape[:-1], *X_WLs.shape[1:]))

    def link_jacobians(self, q: ArrayLike, X_WB: ArrayLike | None = None) -> NDArray[np.float64]:
        """Return J_WL of every link (..., links, 6, joints): its spatial velocity is J_WL @ qdot.

        Spatial velocities are [w_WL, v_WLo], angular before linear, in World axes, the linear part
        that of the link's origin: what ``SignedDistanceResults.jacobian_by_frames`` takes. Joints
        in the order of ``joint_names``, links in that of ``link_names``, arguments as of
        ``link_transforms``.
        """
        X_WLs, tree = self.link_transforms(q, X_WB), self.tree
        p_WLs = X_WLs[..., :3, 3]
        Js = np.zeros((*X_WLs.shape[:-2], 6, len(self.joint_names)))
        for joint, (parent, link) in enumerate(zip(tree.parents, tree.children, strict=True)):
            # The parent's velocity at the child's origin, and the joint's own.
            arms = (p_WLs[..., link, :] - p_WLs[..., parent, :])[..., None]
            Js[..., link, :, :] = Js[..., parent, :, :]
            Js[..., link, 3:, :] += np.cross(Js[..., parent, :3, :], arms, axis=-2)
            if tree.kinds[joint] != JointKind.FIXED:
                axis_W = X_WLs[..., link, :3, :3] @ (tree.multipliers[joint] * tree.axes[joint])
                part = slice(0, 3) if tree.kinds[joint] == JointKind.REVOLUTE else slice(3, 6)
                Js[..., link, part, tree.leaders[joint]] += axis_W
        return Js


def _parsed(urdf_path: str) -> Any:
    """Return the robot of a URDF. Only now its parser is imported: it takes long, as trimesh."""
    try:
        import yourdfpy
    except ImportError as error:
        raise GeometryError(
            f"{urdf_path}: to place a robot's links takes yourdfpy, which cannot be imported "
            f"({error}): pip install yourdfpy, or this package with its extra 'robots'"
        ) from None
    return yourdfpy.URDF.load(str(urdf_path), build_scene_graph=False, load_meshes=False).robot


def _root(robot: Any) -> str:
    """Return the name of the one link that no joint has as its child."""
    children = [j.child for j in robot.joints]
    roots = [link.name for link in robot.links if link.name not in children]
    if len(roots) != 1 or len(set(children)) != len(children):
        raise ValueError(
            f'{robot.name}: links must form one tree; roots are {roots}, '
            f'links with several parents {sorted({c for c in children if children.count(c) > 1})}'
        )
    root: str = roots[0]
    return root


def _parents_first(robot: Any) -> list[Any]:
    """Return the joints so that each one's parent link is the root or a child of one before."""
    placed = {_root(robot)}
    ordered: list[Any] = []
    waiting = list(robot.joints)
    while waiting:
        ready = [j for j in waiting if j.parent in placed]
        if not ready:
            names = [j.name for j in waiting]
            raise ValueError(f'{robot.name}: joints {names} do not hang on the root link')
        ordered += ready
        placed |= {j.child for j in ready}
        waiting = [j for j in waiting if j.child not in placed]
    return ordered


def _mimicked(robot: Any, urdf_path: str) -> dict[str, tuple[str, float, float]]:
    """Return ``(leader, multiplier, offset)`` of each joint, for a fixed one an empty leader."""
    by_name = {j.name: j for j in robot.joints}
    found: dict[str, tuple[str, float, float]] = {}
    for joint in robot.joints:
        if joint.type not in (*_MOVING, 'fixed'):
            raise ValueError(
                f'{urdf_path}: joint {joint.name} has type {joint.type!r}; '
                f'allowed are {", ".join((*_MOVING, "fixed"))}'
            )
        if joint.type == 'fixed':
            found[joint.name] = ('', 0.0, 0.0)
            continue
        name, multiplier, offset = joint.name, 1.0, 0.0
        passed = {name}
        while (mimic := by_name[name].mimic) is not None:
            if mimic.joint not in by_name or mimic.joint in passed:
                raise ValueError(
                    f'{urdf_path}: joint {name} mimics {mimic.joint!r}, which is '
                    f'{"itself mimicking it" if mimic.joint in passed else "not a joint"}'
                )
            offset += multiplier * (mimic.offset or 0.0)
            multiplier *= 1.0 if mimic.multiplier is None else mimic.multiplier
            name = mimic.joint
            passed.add(name)
        found[joint.name] = (name, multiplier, offset)
    return found


def _limits(joint: Any) -> tuple[float, float, float]:
    """Return lower, upper and speed limit of a joint, infinite where it has none."""
    limit = joint.limit
    speed = np.inf if limit is None or not limit.velocity else limit.velocity
    if joint.type == 'continuous' or limit is None:
        return -np.inf, np.inf, speed
    # A missing bound counts as 0 in the URDF specification.
    return limit.lower or 0.0, limit.upper or 0.0, speed


def _unit_axis(joint: Any) -> NDArray[np.float64]:
    """Return the joint's axis with length 1."""
    length = float(np.linalg.norm(joint.axis))
    if joint.type in _MOVING and not (np.isfinite(length) and length > 0.0):
        raise ValueError(f'joint {joint.name} has axis {joint.axis}; it must not be zero')
    axis: NDArray[np.float64] = joint.axis
    return axis / length if length > 0.0 else axis


def _poses_in_parents(joints: list[Any]) -> NDArray[np.float64]:
    """Return X_PJ (m, 7) of each joint in its parent link."""
    origins = [np.eye(4) if j.origin is None else j.origin for j in joints]
    return poses_of_matrices(np.array(origins).reshape(-1, 4, 4))
