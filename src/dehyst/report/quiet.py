"""matplotlib is loaded here first, without its lines about a HOME that cannot be written: nothing is lost by that."""

import logging

_log = logging.getLogger("matplotlib")
_level = _log.level
_log.setLevel(logging.ERROR)
try:
    from matplotlib import font_manager  # looks for its folders and its fonts
finally:
    _log.setLevel(_level)

__all__ = ["font_manager"]
