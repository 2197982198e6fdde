"""Broad phase: the neighbour list of pairs that may be within the cutoff.

Grids for many bodies, all pairs for few. Skins keep a list valid for many cycles. The list holds
pairs (k, 2) with i < j that no filter excludes, each with the slot of its last answer.
"""
