"""Records the topics that reports need as MCAP, for installations without ``ros2 bag``."""
