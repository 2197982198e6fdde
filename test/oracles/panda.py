"""The Panda arm, written down a second time from the maker's Denavit-Hartenberg table."""

import sys
from pathlib import Path

import numpy as np

# Franka's modified (Craig) parameters of frames 1 to 7 and the flange: a [m], d [m], alpha [rad].
# Source: Franka Control Interface documentation, "Denavit-Hartenberg parameters".
MODIFIED_DH = [
    (0.0, 0.333, 0.0),
    (0.0, 0.0, -np.pi / 2),
    (0.0, 0.316, np.pi / 2),
    (0.0825, 0.0, np.pi / 2),
    (-0.0825, 0.384, -np.pi / 2),
    (0.0, 0.0, np.pi / 2),
    (0.088, 0.0, np.pi / 2),
]
FLANGE = 0.107
HAND_YAW = -np.pi / 4
FINGER = 0.0584

URDF = next(
    path
    for entry in sys.path
    if (
        path := Path(entry)
        / 'cmeel.prefix/share/example-robot-data/robots/panda_description/urdf'
        / 'panda_collision.urdf'
    ).is_file()
)


def _craig(a, d, alpha, theta):
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    return np.array(
        [
            [ct, -st, 0, a],
            [st * ca, ct * ca, -sa, -d * sa],
            [st * sa, ct * sa, ca, d * ca],
            [0, 0, 0, 1],
        ]
    )


def link_transforms(q):
    """X_BL of ``panda_link0`` ... and the hand and fingers, for 7 angles and the finger's way."""
    X = np.eye(4)
    links = {'panda_link0': X}
    for k, (a, d, alpha) in enumerate(MODIFIED_DH):
        X = X @ _craig(a, d, alpha, q[k])
        links[f'panda_link{k + 1}'] = X
    links['panda_link8'] = X @ _craig(0.0, FLANGE, 0.0, 0.0)
    hand = links['panda_link8'] @ _craig(0.0, 0.0, 0.0, HAND_YAW)
    links['panda_hand'] = hand
    for name, way in (('panda_leftfinger', q[7]), ('panda_rightfinger', -q[7])):
        X_HF = np.eye(4)
        X_HF[:3, 3] = [0.0, way, FINGER]
        links[name] = hand @ X_HF
    return links
