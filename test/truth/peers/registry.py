"""Which peers there are, which are installed, and how one is loaded."""

from __future__ import annotations

from importlib import import_module, metadata
from importlib.util import find_spec
from typing import NamedTuple, cast

from drake_geom_ros.cross_check.answers import Peer, Unsupported


class _PeerEntry(NamedTuple):
    module: str  # what is imported
    distribution: str  # what is installed
    adapter: str  # module with its class
    made_by: str  # that class


_PEERS = {
    'pydrake': _PeerEntry('pydrake', 'drake', 'truth.peers.pydrake_peer', 'PydrakePeer'),
    'python-fcl': _PeerEntry(
        'fcl', 'python-fcl', 'drake_geom_ros.cross_check.fcl_peer', 'FclPeer'
    ),
    'Coal': _PeerEntry('coal', 'coal', 'truth.peers.coal_peer', 'CoalPeer'),
    'MuJoCo': _PeerEntry('mujoco', 'mujoco', 'truth.peers.mujoco_peer', 'MuJoCoPeer'),
}


def names() -> tuple[str, ...]:
    """Return the names of all peers that this package knows, installed or not."""
    return tuple(_PEERS)


def installed() -> tuple[str, ...]:
    """Return the names of the peers that are installed; none of them is imported."""
    return tuple(name for name, entry in _PEERS.items() if find_spec(entry.module) is not None)


def version(name: str) -> str:
    """Return the version of a peer that is installed; raises Unsupported if it is not."""
    try:
        return metadata.version(_entry(name).distribution)
    except metadata.PackageNotFoundError:
        raise Unsupported(_absent(name)) from None


def load(name: str, tolerance: float | None = None) -> Peer:
    """Import a peer and return it, with its own settings or with one tolerance [m] for all.

    Raises Unsupported for a name that is not in ``names()``, for a peer that is not installed and
    for a tolerance where the peer offers none.
    """
    entry = _entry(name)
    if find_spec(entry.module) is None:
        raise Unsupported(_absent(name))
    adapter = import_module(entry.adapter)
    return cast(Peer, getattr(adapter, entry.made_by)(tolerance))


def _entry(name: str) -> _PeerEntry:
    if name not in _PEERS:
        raise Unsupported(f'no peer is called {name!r}; there are: {", ".join(_PEERS)}')
    return _PEERS[name]


def _absent(name: str) -> str:
    return (
        f'{name} is not installed here: pip install {_PEERS[name].distribution} '
        '(requirements/peers.txt has the versions that are measured)'
    )
