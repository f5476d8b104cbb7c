"""The candidates: plays and the curve, families of the literature and rows of elements, the direct inverse."""

from __future__ import annotations

from dehyst.errors import ParameterError
from dehyst.families import is_family, names
from dehyst.families import kit as families_kit
from dehyst.identification._candidate import Candidate
from dehyst.identification._candidates.direct import Direct
from dehyst.identification._candidates.literature import Literature
from dehyst.identification._candidates.plays import plays_of

__all__ = ["Candidate", "Direct", "Literature", "all_names", "candidate_of", "plays_of"]


def all_names() -> tuple[str, ...]:
    """Every family that can be fitted by its name.

    Examples
    --------
    >>> all_names()[:3]
    ('static', 'pi', 'pi-cumulative')
    """
    return (*families_kit.TITLES, *names())


def candidate_of(name: str, seed: int = 0) -> Candidate:
    """Return a family with its usual settings.

    Raises
    ------
    ParameterError
        If there is none of that name.
    """
    if name not in families_kit.TITLES and not is_family(name):
        raise ParameterError(
            f"no family '{name!s:.40}'. There are: {', '.join(all_names())}.", names=[name]
        )
    if name == Direct.family:
        return Direct()
    return plays_of(name) if name in families_kit.TITLES else Literature(name, seed)
