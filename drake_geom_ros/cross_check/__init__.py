"""A second opinion about answers of ours: python-fcl's, in processes that may be lost.

============================  ==================================================================
``question``                  what is asked and what comes back: plain data, for both sides
``asker``                     the node's side: starts the process, and again when it was lost
``python -m``                 the process: reads batches of questions, sends verdicts
``second_opinion``            FCL, in a process below that it may end or hang
``judging``                   whose answer is wrong, where the two differ
============================  ==================================================================

The last three import ``evidence``, and the node imports none of them.
"""
