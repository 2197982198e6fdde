"""Publishers that need rclpy: results as bytes, diagnostics, cameras, answers of services.

Each publishes or writes its part of the live scene when it is due.
"""
