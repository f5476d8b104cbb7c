"""Whether the actuator depends on rate and time: the same fit with and without those terms, on blocks held out."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from dehyst.identification.direct.columns import Layout, Shape
from dehyst.identification.direct.program import Block, held_out

Array = npt.NDArray[np.float64]

MOST_BLOCKS = 10
# All 2^10 ways to exchange "with" and "without" in the blocks.
_SIGNS = 1.0 - 2.0 * ((np.arange(1 << MOST_BLOCKS)[:, None] >> np.arange(MOST_BLOCKS)) & 1)


@dataclass(frozen=True, slots=True)
class Evidence:
    """What a group of terms is worth on data that was not fitted.

    Attributes
    ----------
    group
        "viscous" or "creep".
    without_percent, with_percent
        RMS error on held-out blocks without and with the group, percent of the input's range.
    better
        In how many blocks the error is smaller with it.
    blocks
        Number of blocks.
    p
        How often a mean improvement as large as this one, or larger, would come about if the group made no difference:
        the share of all exchanges of "with" and "without" within blocks (exact permutation test, one-sided). Blocks are
        neighbours in time, so it is a guide and no proof.
    kept
        Whether the model has the group.
    held
        Whether the log holds still for long enough to tell: without holds stops imitate creep. True for "viscous".
    """

    group: str
    without_percent: float
    with_percent: float
    better: int
    blocks: int
    p: float
    kept: bool
    held: bool = True

    @property
    def there(self) -> bool:
        """Whether the dependence is there: p below 5 %, and an error smaller by more than 2 %."""
        return self.p < 0.05 and self.with_percent < 0.98 * self.without_percent

    def as_dict(self) -> dict[str, object]:
        """Return the values as printed by ``--json``."""
        return {
            "group": self.group,
            "without_percent": self.without_percent,
            "with_percent": self.with_percent,
            "better": self.better,
            "blocks": self.blocks,
            "p": self.p,
            "there": self.there,
            "kept": self.kept,
            "held": self.held,
        }

    @property
    def figures(self) -> str:
        """Both errors, with as many digits as tell them apart, at most four."""
        without, with_it = self.without_percent, self.with_percent
        for digits in (2, 3, 4):
            if f"{without:.{digits}f}" != f"{with_it:.{digits}f}":
                break
        return f"{without:.{digits}f} % of range without, {with_it:.{digits}f} % with it"

    def __str__(self) -> str:
        """One sentence."""
        name = "rate (viscous term)" if self.group == "viscous" else "time (creep)"
        if self.there:
            answer = "found" if self.held else "found, but stops may imitate it: the log never holds still for long"
        else:
            answer = "not found" if self.held else "cannot be told: the log never holds still for long"
        if self.kept != self.there:  # the terms of a model are chosen on fewer, longer blocks
            answer += (
                ", and kept in the model" if self.kept else ", but worth less than 2 % on longer blocks: not in it"
            )
        return (
            f"dependence on {name}: {answer}; {self.figures} on held-out blocks, better in {self.better} of "
            f"{self.blocks}, p = {self.p:.2g}"
        )


def evidence(
    layout: Layout, shape: Shape, blocks: list[Block], percent: float, groups: tuple[str, ...], held: bool
) -> tuple[Evidence, ...]:
    """Test groups of terms, each beside all the others of a shape.

    Parameters
    ----------
    blocks
        The fitted rows, at most ten blocks of them.
    percent
        What 1 in scaled units is in percent of the input's range.
    groups
        Which of "viscous" and "creep" to test.
    held
        Whether the log holds still for long enough to tell creep from stops.
    """
    return tuple(_test(layout, shape, blocks, percent, group, held or group != "creep") for group in groups)


def _test(layout: Layout, shape: Shape, blocks: list[Block], percent: float, group: str, held: bool) -> Evidence:
    with_it = shape.with_group(group)
    without_it = replace(shape, groups=tuple(name for name in shape.groups if name != group))
    errors = [held_out(layout, each, blocks) ** 2 for each in (without_it, with_it)]
    return Evidence(
        group,
        percent * float(np.sqrt(np.mean(errors[0]))),
        percent * float(np.sqrt(np.mean(errors[1]))),
        int(np.sum(errors[1] < errors[0])),
        len(blocks),
        permutation_p(errors[0] - errors[1]),
        group in shape.groups,
        held,
    )


def permutation_p(gains: Array) -> float:
    """Share of all sign changes of the gains whose mean is at least as large as theirs.

    Examples
    --------
    >>> permutation_p(np.ones(10))
    0.0009765625
    >>> permutation_p(np.zeros(10))
    1.0
    """
    means = _SIGNS[: 1 << gains.size, : gains.size] @ gains
    return float(np.mean(means >= means[0] - 1e-12 * np.sum(np.abs(gains))))
