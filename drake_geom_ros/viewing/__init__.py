"""What people look at: scenes, answers and filters as a page shows them. No ROS.

In: a scene, its poses and the answers.
Out: what a page shows, as plain data.
May import: ``math``, ``common``, ``sensors``, ``geometry``, ``proximity_rules``, ``scene_files``,
    ``trajectories``; numpy, yaml, PIL.
"""
