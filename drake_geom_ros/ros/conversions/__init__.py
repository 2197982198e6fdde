"""Messages to values of the core and back: here messages stop.

No ROS import: a function reads or fills any object with the fields of the message, so that plain
objects test it. What a message holds is checked here, once; errors name the field.

In: messages, or any objects with their fields.
Out: values of the core, checked once; errors name the field.
May import: ``math``, ``common``, ``sensors``, ``geometry``, ``proximity_rules``, ``sensed_maps``,
    ``scene_files``; numpy.
"""
