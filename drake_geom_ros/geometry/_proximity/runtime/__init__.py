"""What stands between Python and compiled code.

Enters: functions and arrays. Leaves: compiled functions with their cache, records of arrays as
compiled code takes them, views, addresses of kernels, the clock, threads. Knows nothing of
geometry, and imports nothing of ours but tolerances.
"""
