"""Stops in closed form: how far joints and bases have gone on at a time."""

from __future__ import annotations

import numpy as np


def progress(times, share, reaction, braking):
    """Return how long (n,) [s] the present speed takes for what a stop has covered at ``times``.

    The stop begins at ``share`` of the present speed, which stays for ``reaction`` [s] and falls
    evenly to 0 within ``braking`` [s].
    """
    t = np.asarray(times, dtype=float)
    after = np.clip(t - reaction, 0.0, braking)
    slower = after * after / (2.0 * braking) if braking else 0.0
    return share * (np.minimum(t, reaction) + after - slower)


def base_poses(X_PB, twist, seconds):
    """Return X_PB (n, 4, 4) of a base that went on for some ``seconds`` (n,) at its twist.

    ``twist`` is x, y [m/s] and theta [rad/s] in its own axes. In complex numbers the way is the
    integral of ``(x + i y) exp(i theta t)``.
    """
    (x, y, theta), t = twist, np.asarray(seconds, dtype=float)
    half = 0.5 * theta * t
    way = (x + 1j * y) * t * np.exp(1j * half) * np.sinc(half / np.pi)
    moved = np.tile(np.eye(4), (len(t), 1, 1))
    moved[:, 0, 0] = moved[:, 1, 1] = np.cos(2.0 * half)
    moved[:, 1, 0], moved[:, 0, 1] = np.sin(2.0 * half), -np.sin(2.0 * half)
    moved[:, 0, 3], moved[:, 1, 3] = way.real, way.imag
    return np.asarray(X_PB) @ moved
