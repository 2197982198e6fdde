"""Cross-check of this package's answers by python-fcl, in a process that may crash or hang.

============================  ==================================================================
``question``                  the pairs to check and the verdicts, as plain data for both sides
``asker``                     the node's side: starts the process, and restarts a lost one
``python -m``                 the process: reads batches of questions, sends verdicts
``second_opinion``            FCL, in a child process that may be ended
``fcl_peer`` ``answers``      the calls of FCL for a pair of shapes, and its answers
``lost_process``              that child process
``judging``                   the verdict on two answers that differ
``bodies`` ``surfaces``       the bodies of a question and their surfaces, by plain formulas
============================  ==================================================================

The node imports the first two alone. ``test/truth`` builds on the last three lines. Verdicts are
counted, and each disagreement is reported with its pair.
"""
