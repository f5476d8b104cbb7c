"""Table of sums of elements: name, direction, and which groups of columns each family has.

This is plain data, and the only place that names a row: the registry, the fit, the pages and the command read it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from dehyst.families._policy import POLICY

# Groups of columns (dehyst.families._columns) -> the terms they add to a sum; z, q and p are memories.
TERMS = {
    "play": "sum of w z,  z = max(x - r, min(x + r, z))",
    "stop": "sum of w (x - z),  z as of a play",
    "lag": "sum of g(z),  z as of a play, g rising: the generalised play with envelopes g(x - r) and g(x + r)",
    "lead": "sum of f(x) - g(z),  z as of a play, f steeper than g",
    "creep": "sum of w q,  q <- q + (1 - exp(-h / tau)) (z - q),  z between q, x - r and x + r",
    "viscous": "sum of w q,  q as of creep, tau as short as the loop is to widen with the rate: by 2 tau |x'|",
    "creep-by-place": "sum of g(q),  q as of creep without r",
    "relax": "sum of w (x - q),  q as of creep without r, of the sample before",
    "relax-by-place": "sum of g(x) - g(q),  q as of creep without r, of the sample before",
    "rate": "sum of w clip((x - q) / s, -1, 1),  q as of creep, of the sample before: dampers that saturate",
    "product": "sum of w q q',  q and q' as of creep without r, of the sample before, within the range; w of any sign",
    "path": "sum of w p,  p <- s r + exp(-|x - x'| / r) (p - s r),  s the sign of x - x'",
}
# Groups that add only loops that run counter-clockwise.
LAGGING = frozenset(("play", "lag", "creep", "viscous", "creep-by-place"))
# Groups whose elements take time: they need a log with time stamps.
TIMED = frozenset(
    ("creep", "viscous", "creep-by-place", "relax", "relax-by-place", "rate", "product")
)


@dataclass(frozen=True)
class Sum:
    """The sum that a row asks for: its name, groups of columns, direction, and with or without a map, or both."""

    name: str
    groups: tuple[str, ...]
    direction: str = "forward"
    maps: tuple[bool, ...] = (False, True)

    @property
    def timed(self) -> bool:
        """Whether it has elements that take time."""
        return not TIMED.isdisjoint(self.groups)

    @property
    def worth(self) -> float:
        """Share of the error of other sums below which this one is chosen."""
        return POLICY.worth_of_products if "product" in self.groups else 1.0

    @property
    def timeless(self) -> Sum:
        """The same sum for a log without time stamps: without the groups that take time."""
        return replace(self, groups=tuple(group for group in self.groups if group not in TIMED))


@dataclass(frozen=True)
class Row:
    """A family of the grammar.

    Attributes
    ----------
    name, title
        As typed and as written.
    sums
        Its groups of columns and direction; of several the one that errs least within the training.
    chosen
        When the choice among rows looks at it: "always", with "few" turns, with "many", with "many" to "simulate"
        alone, or "never".
    source
        Where it comes from.
    cannot
        What it cannot show.
    """

    name: str
    title: str
    sums: tuple[Sum, ...]
    chosen: str
    source: str
    cannot: str

    @property
    def lags(self) -> bool:
        """Whether its output can only lag: the loops of all its columns run counter-clockwise."""
        for candidate in self.sums:
            if candidate.direction == "inverse" or not LAGGING.issuperset(candidate.groups):
                return False
        return True


def _row(
    name: str,
    title: str,
    groups: str,
    chosen: str,
    source: str,
    cannot: str,
    direction: str = "forward",
) -> Row:
    """Return a row; bars separate alternatives of its groups."""
    # The sum of an inverse row is the input; a map of its output would have to be solved for, too.
    maps = (False, True) if direction == "forward" else (False,)
    sums = []
    for alternative in groups.split("|"):
        sums.append(Sum(name, tuple(alternative.split()), direction, maps))
    return Row(name, title, tuple(sums), chosen, source, cannot)


OWN = "the sum is this project's, docs/decisions/0043"
VOLTERRA = "Volterra 1930, second order; the sum is this project's, docs/decisions/0052"
IWAN = "Iwan 1966; Vo-Minh and others 2011"
CLOCKWISE = "Loops that run clockwise"
ROWS = (
    _row(
        "play-sum", "sum of plays", "play", "always", "Prandtl 1928; Ishlinskii 1944; with a map Kuhnen 2003",
        f"{CLOCKWISE}; rate and creep; loops whose shape depends on the place by more than a map explains.",
    ),
    _row(
        "stop-sum", "sum of stops", "stop", "always", "Prandtl 1928; Iwan 1966",
        "Loops that run counter-clockwise; rate and creep; branches that differ other than by a map.",
    ),
    _row(
        "generalised-pi", "generalised Prandtl-Ishlinskii", "lag", "always",
        "Brokate and Sprekels 1996; Al Janaideh, Rakheja and Su 2011",
        f"{CLOCKWISE}; rate and creep.",
    ),
    _row(
        "creep-pi", "Prandtl-Ishlinskii with creep", "play creep", "always", "Krejci and Kuhnen 2001",
        f"{CLOCKWISE}; creep whose size depends on the place; drift without cause.",
    ),
    _row(
        "rate-dependent-pi", "rate-dependent Prandtl-Ishlinskii", "play viscous", "many",
        "Al Janaideh and Krejci 2013; plays that are viscous: docs/decisions/0046",
        f"{CLOCKWISE}; loops that narrow with the rate; inertia and resonance.",
    ),
    _row(
        "krasnoselskii-pokrovskii", "Krasnosel'skii-Pokrovskii", "lag stop", "never",
        "Krasnosel'skii and Pokrovskii 1983; Banks, Kurdila and Webb 1997",
        "Rate and creep; clockwise loops but those of stops.",
    ),
    _row(
        "maxwell-slip", "Maxwell slip", "stop rate | stop | play viscous | play", "never", IWAN,
        "Branches that differ other than by a map; friction that falls with the speed (Stribeck); inertia.",
    ),
    _row(
        "mixed-sum", "plays, stops, creep, rate", "play stop creep relax rate", "many", OWN,
        "Loops whose shape depends on the place by more than a map explains; inertia.",
    ),
    _row(
        "full-sum", "ramps of plays, creep, rate", "lag lead creep-by-place relax-by-place rate", "many", OWN,
        "Inertia; what few turns do not tell: it has the most weights.",
    ),
    _row(
        "creep-volterra", "plays, creep, products of lags", "play creep product", "simulate", VOLTERRA,
        f"{CLOCKWISE} but those of lags; an inverse that is stable for certain; lags faster than two samples.",
    ),
    _row(
        "mixed-volterra", "plays, stops, creep, rate, products of lags", "play stop creep relax rate product",
        "simulate", VOLTERRA, "An inverse that is stable for certain; what few turns do not tell.",
    ),
    _row(
        "full-volterra", "ramps of plays, creep, rate, products of lags",
        "lag lead creep-by-place relax-by-place rate product", "simulate", VOLTERRA,
        "An inverse that is stable for certain; what few turns do not tell: it has the most weights.",
    ),
    _row(
        "inverse-stop", "inverse: stops, relaxation", "stop relax", "many", OWN,
        "Outputs that stand still while the input moves; noise of the output acts as motion.", "inverse",
    ),
    _row(
        "inverse-stop-rate", "inverse: stops, relaxation, rate", "stop relax rate", "many", OWN,
        "Outputs that stand still while the input moves; noise of the output acts as motion and as rate.", "inverse",
    ),
    _row(
        "inverse-path", "inverse: lags along the way", "path relax", "many", "Dahl 1968; docs/decisions/0043",
        "Outputs with noise: its lags add noise up as way.", "inverse",
    ),
    _row(
        "inverse-stop-path", "inverse: stops, lags along the way", "stop path relax", "many", OWN,
        "Outputs with noise, or that stand still while the input moves.", "inverse",
    ),
)  # fmt: skip
