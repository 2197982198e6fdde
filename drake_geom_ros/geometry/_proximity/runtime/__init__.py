"""What stands between Python and compiled code.

In: functions and arrays.
Out: compiled functions with their cache, records and views of arrays, addresses, clock, threads.
May import: ``math``, ``_proximity``, ``numba_inside``; numpy, numba, llvmlite.
"""
