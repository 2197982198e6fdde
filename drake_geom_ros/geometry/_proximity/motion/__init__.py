"""Continuous collision checks: certified for all times of a motion, not only for samples.

Takes a world of its own, pairs, a motion of frames or joints, and a minimum distance [m]. Returns
clear, contact or unknown, with the times, bounds and pair that decided it.
"""
