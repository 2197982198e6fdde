"""Conversions between ROS messages and values of the core, with all checks of messages.

A function reads or fills any object with the fields of the message, so plain objects test it. Each
message is checked here, once; errors name the field.
"""
