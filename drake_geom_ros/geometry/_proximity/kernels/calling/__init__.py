"""Calls of kernels: signatures, addresses and rows of results.

Pairs of extreme sizes are scaled to about 1 m before the call, and their rows back after it.
"""
