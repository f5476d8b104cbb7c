"""What every object that can be drawn offers: `plot`, and its look in a notebook."""

from __future__ import annotations

from typing import Any


class Plotted:
    """A recording or a result. What draws it stands on this module, so it is found by its public name when called."""

    def plot(self, ax: Any = None) -> Any:
        """Draw into matplotlib axes, by default those of a new figure, and return them; see `dehyst.plot`."""
        import dehyst

        return dehyst.plot(self, ax)

    def _repr_html_(self) -> str:
        import dehyst

        return dehyst.as_html(self)
