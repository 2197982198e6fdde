"""Messages as plain values, and as the YAML that ``ros2 topic echo --full-length`` prints."""

import numpy as np
import yaml


def plain(value):
    """Return what a message, or a field of one, holds."""
    if hasattr(value, 'get_fields_and_field_types'):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, (str, bool, int, float)):
        return value
    return [plain(each) for each in np.asarray(value).tolist()] if len(value) else []


def echoed(messages):
    """Return messages as YAML documents."""
    texts = [yaml.safe_dump(plain(message), sort_keys=False) for message in messages]
    return ''.join(f'{text}---\n' for text in texts)
