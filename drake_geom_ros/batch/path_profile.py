"""Profile of a path, piece by piece, for tables and plots: proved bounds and distances."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.batch.evaluation import evaluate
from drake_geom_ros.batch.joints import Joints
from drake_geom_ros.batch.paths import PathChecker
from drake_geom_ros.geometry import MotionCheck, SceneGraph, SceneGraphContext
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.trajectories.joint_spline import JointSpline


class PathProfile(NamedTuple):
    """Pieces (n,) of a path, each checked separately, and the states (n + 1,) between them."""

    times: Floats  # (n + 1,) by rows of the path, or [s]
    outcomes: tuple[str, ...]  # (n,)
    lower_bounds: Floats  # (n,) [m] certified for all times of a clear piece
    distances: Floats  # (n + 1,) [m] the smallest of each state
    error_bounds: Floats  # (n + 1,) [m]


def profile_of_path(
    scene_graph: SceneGraph | SceneGraphContext,
    joints: Joints,
    path: ArrayLike,
    pieces: int = 200,
    **options: Any,
) -> PathProfile:
    """Return the profile of a path (k, q) in ``pieces``; ``options`` are those of ``check_path``.

    The bound of a piece that is not clear is NaN.
    """
    rows = np.asarray(path, dtype=np.float64)
    inner = np.linspace(0.0, len(rows) - 1.0, max(pieces, 1) + 1)
    times = np.union1d(inner, np.arange(len(rows)))
    row_times = np.arange(len(rows))
    states = np.column_stack([np.interp(times, row_times, column) for column in rows.T])
    checks = PathChecker(scene_graph, joints, **options).check_edges(states)
    return _profile(scene_graph, joints, times, checks, states)


def profile_of_spline(
    scene_graph: SceneGraph | SceneGraphContext,
    joints: Joints,
    spline: JointSpline,
    pieces: int = 200,
    **options: Any,
) -> PathProfile:
    """Return the profile of a spline in ``pieces`` of time, and at its points; times in seconds.

    Args and options are those of ``profile_of_path``.
    """
    inner = np.linspace(spline.times[0], spline.times[-1], max(pieces, 1) + 1)
    times = np.union1d(inner, spline.times)
    checker = PathChecker(scene_graph, joints, **options)
    checker.refuse_limits(spline)
    checks = checker.check_between(spline, times)
    states = np.array([spline.value(time) for time in times.tolist()])
    return _profile(scene_graph, joints, times, checks, states)


def _profile(
    scene_graph: SceneGraph | SceneGraphContext,
    joints: Joints,
    times: Floats,
    checks: list[MotionCheck],
    states: Floats,
) -> PathProfile:
    """Return the profile of checked pieces, with the distances of the states between them."""
    least = evaluate(scene_graph, states=states, joints=joints, want='least')
    return PathProfile(
        times=times,
        outcomes=tuple(check.outcome for check in checks),
        lower_bounds=np.array(
            [check.lower_bound if check.outcome == 'clear' else np.nan for check in checks]
        ),
        distances=least.distance,
        error_bounds=least.error_bound,
    )


def draw_profile(
    profile: PathProfile,
    check: MotionCheck,
    min_distance: float,
    title: str,
    file: Path,
    unit: str = 'rows of the path',
) -> None:
    """Draw distances and proved bounds over time, with contacts and unknown pieces shaded."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 4), layout='constrained')
    axes = figure.subplots()
    axes.plot(
        profile.times, profile.distances, color='#1f5fb4', label='minimum distance of states'
    )
    if len(profile.times) > 1:
        axes.stairs(
            profile.lower_bounds,
            profile.times,
            baseline=None,
            color='#6fa8dc',
            label='proved for all times of a piece',
        )
    axes.axhline(min_distance, color='black', linewidth=0.8, linestyle=':')
    shades = {'contact': '#f25900', 'unknown': '#9aa3ad'}
    for outcome, pieces in groupby(range(len(profile.outcomes)), profile.outcomes.__getitem__):
        first, *others = pieces  # neighbours are joined, since there would be seams between them
        end = min(first + len(others) + 1, len(profile.times) - 1)
        if outcome in shades:
            span = profile.times[first], profile.times[end]
            axes.axvspan(*span, color=shades[outcome], alpha=0.25, linewidth=0, label=outcome)
    if check.outcome != 'clear':
        axes.axvline(
            check.times[1], color='#f25900', linewidth=1.2, label=f'first: {check.outcome}'
        )
    axes.set(title=title, xlabel=f'time [{unit}]', ylabel='distance [m]')
    named = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))  # each once
    figure.legend(named.values(), named, loc='outside lower center', ncols=5, fontsize='small')
    figure.savefig(file, dpi=120)
