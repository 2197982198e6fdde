"""Compiled loops over many states of one scene, each answered as if it were alone.

Takes a world of its own, pairs and poses (N, n, 7). No answer depends on another state's.
"""
