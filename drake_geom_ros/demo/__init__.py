"""The demo: three ROS processes, and what a person sees of them. Nothing here imports ROS."""
