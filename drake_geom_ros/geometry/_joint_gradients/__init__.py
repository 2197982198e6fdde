"""Gradients of distances by joint values (private): one compiled call a state.

The input is a prepared check of states (``_proximity.states``) and the joints that move each
frame. The output is the distances of pairs and their derivatives by the joint values. The kernels
are compiled on first use.
"""
