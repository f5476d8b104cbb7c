"""The version of the package."""

import re

__version__ = "0.2.0.dev0"
RELEASE = ".".join(
    [*re.findall(r"\d+", __version__), "0", "0"][:3]
)  # for tools that take three numbers
