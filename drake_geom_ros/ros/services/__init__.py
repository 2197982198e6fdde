"""Table of all services, and the handlers that need ROS; ``live.services`` has the others.

The message of a failed call states the request, the reason and the allowed values.
"""
