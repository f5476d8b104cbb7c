"""Names of a room, each imported when it is first used: to play a model must not load what identifies one."""

import sys

TYPE_CHECKING = False  # `typing` would be loaded before Ctrl-C is heeded
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import Any


def lazy_names(
    room: str, homes: "Mapping[str, str]"
) -> "tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]":
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` of a room.

    Parameters
    ----------
    room
        Dotted name of the module, a room or its kit.
    homes
        Module below the room, or a whole dotted name -> names that it defines, with blanks between.

    Examples
    --------
    >>> get, _, names = lazy_names("dehyst", {"shell": "quoted command"})
    >>> names, get("quoted")("a b")
    (['command', 'quoted'], '"a b"')
    """
    home_of = {}
    below = room.removesuffix(".kit")
    for module, names in homes.items():
        for name in names.split():
            home_of[name] = module if module.startswith("dehyst") else f"{below}.{module}"

    def get(name: str) -> "Any":
        if name not in home_of:
            raise AttributeError(f"module '{room}' has no attribute '{name}'")
        __import__(home_of[name])
        value = getattr(sys.modules[home_of[name]], name)
        setattr(sys.modules[room], name, value)
        return value

    listed = sorted(home_of)
    return get, lambda: list(listed), listed
