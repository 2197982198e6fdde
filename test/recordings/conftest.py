"""All of it needs the extra ``recordings``."""

import importlib.util

if importlib.util.find_spec('rosbags') is None or importlib.util.find_spec('mcap') is None:
    collect_ignore_glob = ['test_*.py']
