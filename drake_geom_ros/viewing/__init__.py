"""What people look at: scenes, answers and filters as a page shows them. No ROS."""
