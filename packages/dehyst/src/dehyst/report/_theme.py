"""Colours and matplotlib style of all pages and figures, for light and dark screens and colour-blind readers.

Hues follow Okabe and Ito's palette. Every colour that a figure may use is a named token here; in the page a token
becomes a CSS variable, so that figures follow the reader's light or dark setting.
"""

from __future__ import annotations

import logging
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, cast

_log = logging.getLogger("matplotlib")
_level = _log.level
_log.setLevel(
    logging.ERROR
)  # its lines about a HOME that cannot be written: nothing is lost by that
try:
    import matplotlib
    from matplotlib import font_manager  # looks for its folders and its fonts
finally:
    _log.setLevel(_level)


@dataclass(frozen=True, slots=True)
class ThemeColour:
    """A colour by name: its value on white paper and on a dark screen."""

    name: str
    light: str
    dark: str


INK = ThemeColour("ink", "#1b2530", "#e9eef4")
MUTED = ThemeColour("muted", "#566170", "#a3afbd")
GRID = ThemeColour("grid", "#e2e6eb", "#2d3743")
AXIS = ThemeColour("axis", "#97a1ad", "#65717f")
PAPER = ThemeColour("paper", "#fefefe", "#161c24")
TRAIN = ThemeColour("train", "#0072b2", "#5ab4ec")
DATA = ThemeColour("data", "#86bbdf", "#2c6a97")
TEST = ThemeColour("test", "#d55e00", "#ff9a57")
MODEL = ThemeColour("model", "#10161d", "#fbfdff")
STATIC = ThemeColour("static", "#8c4f94", "#d6a3dd")
OTHER = ThemeColour("other", "#8a939e", "#7f8b98")
FIFTH = ThemeColour("fifth", "#007a5a", "#3fcfa0")
SIXTH = ThemeColour("sixth", "#9a7300", "#e3c04a")
BAD = ThemeColour("bad", "#b3261e", "#ff8a80")

TOKENS = (INK, MUTED, GRID, AXIS, PAPER, TRAIN, DATA, TEST, MODEL, STATIC, OTHER, FIFTH, SIXTH, BAD)
CYCLE = (TRAIN, TEST, FIFTH, STATIC, SIXTH, OTHER)

FONT_STACK = 'system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif'

# Families tried in turn for glyphs that DejaVu Sans lacks, where they are installed; in the page the browser chooses.
_FALLBACKS = (
    "Noto Sans CJK JP",
    "Noto Sans CJK SC",
    "WenQuanYi Zen Hei",
    "Hiragino Sans",
    "Microsoft YaHei",
)


def fonts() -> list[str]:
    """Return the font families to draw with, best first; only installed ones, so that none is warned about."""
    installed = set(font_manager.get_font_names())
    return ["DejaVu Sans", *(name for name in _FALLBACKS if name in installed)]


def style() -> dict[str, Any]:
    """Return matplotlib settings of every figure, complete: a user's matplotlibrc does not change a report."""
    defaults: dict[str, Any] = {}
    for key, value in matplotlib.rcParamsDefault.items():
        if key.split(".")[0] in _FAMILIES:
            defaults[key] = value
    return {
        **defaults,
        "font.family": fonts(),
        "font.size": 10.5,
        "text.color": INK.light,
        "text.parse_math": False,  # a column may be called "$p_1$"; it is a name, not a formula
        "svg.fonttype": "none",
        "axes.edgecolor": AXIS.light,
        "axes.linewidth": 0.8,
        "axes.labelcolor": INK.light,
        "axes.labelsize": 10.5,
        "axes.titlesize": 10.5,
        "axes.titlelocation": "left",
        "axes.titlepad": 7.0,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "axes.axisbelow": True,
        "axes.facecolor": "none",
        "axes.unicode_minus": True,
        "axes.formatter.useoffset": False,
        "axes.formatter.limits": (-4, 5),
        "grid.color": GRID.light,
        "grid.linewidth": 0.7,
        "xtick.color": AXIS.light,
        "ytick.color": AXIS.light,
        "xtick.labelcolor": MUTED.light,
        "ytick.labelcolor": MUTED.light,
        "xtick.labelsize": 9.8,
        "ytick.labelsize": 9.8,
        "xtick.major.size": 3.0,
        "ytick.major.size": 3.0,
        "legend.frameon": False,
        "legend.fontsize": 10.0,
        "legend.handlelength": 1.5,
        "legend.handletextpad": 0.5,
        "legend.borderpad": 0.0,
        "legend.borderaxespad": 0.0,
        "legend.columnspacing": 1.3,
        "figure.facecolor": "none",
        "savefig.facecolor": "none",
        "lines.linewidth": 1.2,
        "lines.solid_joinstyle": "round",
        "path.simplify": False,  # thin.py has done it, with a bound on the error
    }


_FAMILIES = {
    "font", "text", "svg", "axes", "grid", "xtick", "ytick", "legend", "figure", "savefig", "lines", "path", "patch",
    "errorbar", "contour", "date", "mathtext", "image", "agg",
}  # fmt: skip


def settings(values: dict[str, Any]) -> AbstractContextManager[None]:
    """Return a context with matplotlib settings; the former ones return at its end."""
    return matplotlib.rc_context(cast(Any, values))  # matplotlib types every key by name


def variables(dark: bool) -> str:
    """Return the tokens as CSS custom properties.

    Examples
    --------
    >>> variables(dark=False)[:16]
    '--ink: #1b2530; '
    """
    return " ".join(f"--{token.name}: {token.dark if dark else token.light};" for token in TOKENS)
