"""Forward kinematics of a URDF tree, vectorised over joints and over configurations."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry import GeometryError

_MOVING = ('revolute', 'continuous', 'prismatic')


class Kinematics:
    """The links of a robot over its independent joints; mimic joints follow their leader.

    ``joined_links`` are the two links of each joint, fixed ones too.

    The URDF is parsed by yourdfpy, which keeps every element and loads no mesh when told so. Its
    own forward kinematics walks a graph in Python, one configuration at a time (milliseconds for
    a dozen links), so the product of the joint transforms is formed here.
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

        self._parents = [self.link_names.index(j.parent) for j in joints]
        self._X_PJ = np.array(
            [np.eye(4) if j.origin is None else j.origin for j in joints]
        ).reshape(-1, 4, 4)
        self._couple(joints, leader)
        axes = np.array([_unit_axis(j) for j in joints]).reshape(-1, 3)
        revolute = np.array([j.type in ('revolute', 'continuous') for j in joints], dtype=float)
        prismatic = np.array([j.type == 'prismatic' for j in joints], dtype=float)
        self._slides = axes * prismatic[:, None]
        self._crosses = _cross_matrices(axes * revolute[:, None])
        self._squares = self._crosses @ self._crosses

    def _couple(self, joints: list[Any], leader: Mapping[str, tuple[str, float, float]]) -> None:
        """Set up ``q_all = q @ _coupling + _offset`` from independent joints to all of them."""
        self._coupling = np.zeros((len(self.joint_names), len(joints)))
        self._offset = np.zeros(len(joints))
        for column, joint in enumerate(joints):
            if joint.type in _MOVING:
                name, multiplier, offset = leader[joint.name]
                self._coupling[self.joint_names.index(name), column] = multiplier
                self._offset[column] = offset

    def link_transforms(self, q: ArrayLike, X_WB: ArrayLike | None = None) -> NDArray[np.float64]:
        """Return X_WL of every link (..., links, 4, 4) for configurations q (..., joints).

        Positions in [m] and angles in [rad], in the order of ``joint_names``; links in the order
        of ``link_names``, the base link B first. ``X_WB`` (4, 4) places it (default: identity).
        The rotation about a unit axis is Rodrigues' formula, I + sin K + (1 - cos) K^2.
        """
        q = np.asarray(q, dtype=float)
        if q.shape[-1:] != (len(self.joint_names),):
            raise ValueError(
                f'{self.name}: q must have shape (..., {len(self.joint_names)}), one value each '
                f'for {", ".join(self.joint_names)}; got {q.shape}'
            )
        q_all = (q @ self._coupling + self._offset)[..., None]
        X_JC = np.zeros((*q_all.shape[:-1], 4, 4))
        X_JC[..., :3, :3] = np.eye(3)
        X_JC[..., :3, :3] += np.sin(q_all)[..., None] * self._crosses
        X_JC[..., :3, :3] += (1.0 - np.cos(q_all))[..., None] * self._squares
        X_JC[..., :3, 3] = q_all * self._slides
        X_JC[..., 3, 3] = 1.0
        X_PC = self._X_PJ @ X_JC
        X_WL = np.empty((*q.shape[:-1], len(self.link_names), 4, 4))
        X_WL[..., 0, :, :] = np.eye(4) if X_WB is None else X_WB
        for joint, parent in enumerate(self._parents):
            X_WL[..., joint + 1, :, :] = X_WL[..., parent, :, :] @ X_PC[..., joint, :, :]
        return X_WL


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


def _cross_matrices(axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return K (n, 3, 3) with K v = axis x v for axes (n, 3)."""
    K = np.zeros((len(axes), 3, 3))
    K[:, 2, 1], K[:, 0, 2], K[:, 1, 0] = axes.T
    return K - np.swapaxes(K, 1, 2)
