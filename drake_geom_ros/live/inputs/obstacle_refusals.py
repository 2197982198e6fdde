"""Reasons for which maps cannot be made as parameters say."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence

from drake_geom_ros.live.inputs.obstacle_records import INPUTS, OCTOMAP, SELF_FILTERS


def refusal_of_obstacles(names: Sequence[str], self_filter: str, box: Sequence[float]) -> str:
    """Return why ``obstacles``, ``obstacle_self_filter`` or ``obstacle_box`` cannot be, or ''."""
    if unknown := [name for name in names if name not in INPUTS]:
        return f'obstacles names {unknown[0]!r}; it may name {", ".join(INPUTS)}'
    if self_filter not in SELF_FILTERS:
        return (
            f'obstacle_self_filter is {self_filter!r}; it must be one of {", ".join(SELF_FILTERS)}'
        )
    if box and (len(box) != 6 or not all(a < b for a, b in zip(box[:3], box[3:], strict=True))):
        return (
            f'obstacle_box is {list(box)}; it must be empty or six numbers, x, y, z of the lowest '
            'and of the highest corner [m], each of the first three less than its fellow'
        )
    return package_refusal('octomap_msgs', 'obstacles names octomap') if OCTOMAP in names else ''


def package_refusal(package: str, who: str) -> str:
    """Return why messages of a package cannot be taken, beginning with who asks for it, or ''."""
    if importlib.util.find_spec(package) is not None:
        return ''
    return (
        f'{who}, and the package {package} cannot be imported; install it with the ROS '
        'distribution, or send points'
    )
