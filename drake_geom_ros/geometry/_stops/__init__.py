"""Stops as paths of motion checks (private): few compiled calls for all pairs of a proof.

The input is a motion check of a world (``_proximity.motion``), joint values and how they brake.
The output is the path that holds all stops, for the check, and the largest share of the present
speed that it proved. The kernels are compiled on first use.
"""
