"""Many states of one scene, in compiled loops, each as if it was asked about alone.

Enters: a world of its own, pairs, poses (N, n, 7). Leaves: answers by state. No answer enters the
next. Imports ``pairs``, ``points``, ``world`` and ``runtime``.
"""
