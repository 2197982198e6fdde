"""What comes in by itself: transforms, robot descriptions, points. No ROS import."""
