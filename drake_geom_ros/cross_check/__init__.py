"""A second opinion about answers of ours: python-fcl's, in processes that may be lost.

============================  ==================================================================
``question``                  what is asked and what comes back: plain data, for both sides
``asker``                     the node's side: starts the process, and again when it was lost
``python -m``                 the process: reads batches of questions, sends verdicts
``second_opinion``            FCL, in a process below that it may end or hang
``fcl_peer`` ``answers``      how FCL is asked about two shapes, and what it answers
``lost_process``              that process
``judging``                   whose answer is wrong, where the two differ
``bodies`` ``surfaces``       what is asked about, and what it is, by plain formulas
============================  ==================================================================

The node imports the first two alone. ``test/truth`` builds on the last three lines.

In: pairs as they were answered, from a node or a program.
Out: verdicts, counted, and those that disagree.
May import: ``math``, ``common``, ``geometry``, ``sensed_maps``, ``replay``; numpy, scipy, fcl.
"""
