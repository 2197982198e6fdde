"""Bridge between Python and compiled code.

Compiles functions and manages their cache, and provides records and views of arrays, addresses, a
clock and threads.
"""
