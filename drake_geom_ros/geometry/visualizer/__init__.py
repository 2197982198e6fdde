"""``DrakeVisualizer``: load and draw messages of a scene for Drake's visualiser, over LCM."""
