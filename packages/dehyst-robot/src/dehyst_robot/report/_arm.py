"""Animation of the arm along its path: SVG without scripts, tool errors magnified."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import escape

from dehyst.arrays import Array
from dehyst.report import Window
from dehyst.report import kit as report_kit
from dehyst.shell import visible_lines as clean
from dehyst_robot.experiments import PlantResult, Reproduction
from dehyst_robot.experiments import kit as experiments_kit
from dehyst_robot.report._numbers import OFF, first_cycle, left_off, pair_of, same_run, trial_name

# Seconds that one cycle takes on the page, at most; a shorter one is shown as it is.
SHOWN = 16.0
# The largest error of the tool is drawn at most this share of the path's size.
VISIBLE = 0.09
# Errors are drawn larger by one of these, so that a reader can measure them on the picture.
ROUND_FACTORS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)


Runs = Mapping[str, experiments_kit.TrialRun]
Choice = tuple[PlantResult, str, Runs]  # plant, trial, and its runs that differ


@dataclass(frozen=True)
class Scene:
    """The moving picture: its views as (title, SVG), the words below, the sides that are drawn ("off", "on")."""

    views: tuple[tuple[str, str], ...]
    caption: str
    sides: tuple[str, ...]

    def __html__(self) -> str:
        """As it stands on the page."""
        keys = ""
        for side, words in (("off", "tool without compensator"), ("on", "with compensator")):
            if side in self.sides:
                keys += f'<span class="key {side}">{words}</span>\n'
        views = ""
        for title, svg in self.views:
            views += f"<figure>\n<figcaption>{title}</figcaption>\n{svg}\n</figure>\n"
        return (
            '<section class="figure" id="arm">\n'
            '<input type="checkbox" id="hold"><label for="hold">still picture</label>\n'
            f'<p class="keys"><span class="key wanted">desired path</span>\n{keys}</p>\n'
            f'<div class="stage">\n{views}</div>\n'
            f'<p class="caption">{escape(clean(self.caption))}</p>\n</section>\n'
        )


def scene(result: Reproduction) -> Scene | None:
    """Return the moving picture of the first plant whose runs hold poses of the arm, or None."""
    plants = [*result.plants.values()]
    plants.sort(key=_without_compensator)  # stable: the first plant that shows a difference
    for plant in plants:
        choice = _choose(plant, result.compensator)
        if choice is not None:
            return _scene(*choice)
    return None


def _scene(plant: PlantResult, trial: str, runs: Runs) -> Scene:
    factor = magnification(runs.values())
    track = _track(runs, factor)
    duration = float(track.frame_time[-1] - track.frame_time[0])
    faster = duration / track.seconds
    speed = "in real time"
    if faster >= 1.05:
        speed = f"shown {report_kit.number(faster, 2)} times as fast as it was"
    size, close_up_title = "in true size", "The path in its own plane"
    if factor != 1.0:
        size = f"drawn {factor:g} times larger"
        close_up_title += f", errors × {factor:g}"
    left = ""
    if len(runs) == 1:
        left = " The compensator was left off: the runs without and with it are the same."
    return Scene(
        (("The whole arm", whole_arm(track)), (close_up_title, close_up(track))),
        f"Plant {report_kit.short(plant.plant, 40)}, {trial_name(trial)} trial, first cycle, {speed}; errors of the "
        f"tool {size}.{left}",
        tuple(track.traces),
    )


def _without_compensator(plant: PlantResult) -> bool:
    joints = plant.identifications
    return bool(joints) and all(left_off(plant, joint) for joint in joints)


def _choose(plant: PlantResult, compensator: str) -> Choice | None:
    """The slow trial, which the headline is about, or the first one that has poses."""
    for trial in ("slow", *experiments_kit.TRIALS):
        off, on = pair_of(plant, trial, compensator)
        runs = {}
        if off is not None:
            runs[OFF] = off
        if on is not None and not same_run(off, on):
            runs["on"] = on
        if any(len(run.frames) > 1 for run in runs.values()):
            return plant, trial, runs
    return None


def magnification(runs: Iterable[experiments_kit.TrialRun]) -> float:
    """Return by which round factor, 1 to 1000, the errors of the tool are drawn larger."""
    size, largest = 0.0, 0.0
    for run in runs:
        part = first_cycle(run)
        error = np.linalg.norm((run.tool - run.tool_desired)[part], axis=1)
        # Measured against the path: a small path shows small errors as well.
        size = max(size, float(np.max(np.ptp(run.tool_desired[part], axis=0))))
        # The worst 2 % are left out: a short peak must not make all other errors invisible.
        largest = max(largest, float(np.quantile(error, 0.98)))
    factor = 1.0
    for round_factor in ROUND_FACTORS:
        if 0.0 < round_factor * largest <= VISIBLE * size:
            factor = round_factor
    return factor


def _track(runs: Mapping[str, experiments_kit.TrialRun], factor: float) -> Track:
    # The poses are those of the run with compensator, where it has some.
    posed = next(run for run in reversed(list(runs.values())) if len(run.frames) > 1)
    part = first_cycle(posed)
    traces = {}
    for side, run in runs.items():
        magnified = run.tool_desired + factor * (run.tool - run.tool_desired)
        traces[side] = (run.time[first_cycle(run)], magnified[first_cycle(run)])
    duration = float(posed.frame_time[-1] - posed.frame_time[0])
    return Track(
        posed.tool_desired[part],
        traces,
        posed.frames,
        posed.frame_time,
        min(SHOWN, max(duration, 1.0)),
    )


WIDTH = 560.0  # of a view, in its own pixels
# Of an arm of seven joints, and of any other one (the last frame is the tool's):
# thickness of the links [m] between which frames: column and upper arm, elbow, forearm, wrist.
LINKS = ((0, 4, 0.064), (3, 6, 0.048), (5, 8, 0.030))
KNOBS = (
    (0, 0.021),
    (1, 0.021),
    (3, 0.021),
    (5, 0.014),
    (6, 0.011),
)  # joints that can be seen to turn [m]
LINK, KNOB = 0.045, 0.018  # [m]
POST, FOOT = 0.085, 0.13  # of the pedestal [m]
LEVEL = 0.95  # a plane whose normal points up more than this has no upper side: forward is up
TILE = 0.2  # of the floor [m]


@dataclass(frozen=True)
class Track:
    """What is drawn."""

    desired: Array  # (T, 3) path of the tool [m]
    traces: Mapping[
        str, tuple[Array, Array]
    ]  # side -> time (T,) and place of the tool, its error magnified (T, 3)
    frames: Array  # (K, n + 1, 3) poses [m]
    frame_time: Array  # (K,) [s]
    seconds: float  # that the animation takes


@dataclass(frozen=True)
class View:
    """Parallel projection: pixels right and down of points in m."""

    right: Array
    up: Array
    scale: float
    corner: Array
    height: float

    def __call__(self, points: Array) -> Array:
        """Return pixels (..., 2) of points (..., 3)."""
        flat = np.stack([points @ self.right, -(points @ self.up)], axis=-1)
        pixels: Array = (flat - self.corner) * self.scale
        return pixels


def whole_arm(track: Track) -> str:
    """Return the arm on its pedestal, seen from behind on its right and above: on the side that its path faces."""
    azimuth, elevation = np.deg2rad(-118.0), np.deg2rad(28.0)
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    up = np.array(
        [*(-np.sin(elevation) * np.array([np.cos(azimuth), np.sin(azimuth)])), np.cos(elevation)]
    )
    places = [track.frames.reshape(-1, 3), _floor(track), *_tool_places(track)]
    view = _fitted(right, up, np.concatenate(places), 0.03)
    label = "The whole arm, its desired path and the traces of its tool."
    return _drawing(track, view, label, _scenery(track, view), shadow=True)


def close_up(track: Track) -> str:
    """Return the path seen at right angles to its plane, from above."""
    view = _fitted(*plane_of(track.desired), np.concatenate(_tool_places(track)), 0.09)
    label = "The path in its own plane: desired, and traced by the tool with its errors magnified."
    return _drawing(track, view, label, "", shadow=False)


def plane_of(points: Array) -> tuple[Array, Array]:
    """Return directions right and up in the plane that points (T, 3) lie in, seen from above.

    Examples
    --------
    >>> turn = np.linspace(0.0, 6.0, 50)
    >>> circle = np.column_stack([np.cos(turn), np.sin(turn), np.cos(turn)])  # rises forward
    >>> [(direction.round(3) + 0.0).tolist() for direction in plane_of(circle)]
    [[0.0, -1.0, 0.0], [0.707, 0.0, 0.707]]
    """
    normal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][2]
    # Of the two sides of the plane the upper one is shown.
    if normal[2] < 0.0:
        normal = -normal
    reference = np.array([0.0, 0.0, 1.0])
    if normal[2] >= LEVEL:
        reference = np.array([1.0, 0.0, 0.0])
    up = reference - (reference @ normal) * normal
    up = up / np.linalg.norm(up)
    return np.cross(up, normal), up


def _fitted(right: Array, up: Array, points: Array, margin: float) -> View:
    flat = np.stack([points @ right, -(points @ up)], axis=-1)
    low, high = flat.min(axis=0), flat.max(axis=0)
    room = margin * float(np.max(high - low))
    # A path along a line has no width, and nothing may be divided by zero.
    low, span = low - room, np.maximum(high - low + 2 * room, 1e-6)
    scale = WIDTH / float(max(span))
    # The shorter direction stays in the middle.
    low[0] -= (WIDTH / scale - span[0]) / 2.0
    return View(right, up, scale, low, float(span[1]) * scale)


def _drawing(track: Track, view: View, label: str, scenery: str, *, shadow: bool) -> str:
    # The still pose has the tool far to the right, so that the arm covers little of the path.
    still = int(np.argmax(view(track.frames[:, -1])[:, 0]))
    desired = f'<path class="wanted" d="{_outline(view(track.desired))}"/>'
    # The still picture shows the whole traces; the moving one lets them grow over faint ones.
    full, faint, growing = "", "", ""
    for side, (t, places) in track.traces.items():
        flat = view(places)
        outline = _outline(flat)
        full += f'<path class="trace {side}" d="{outline}"/>'
        faint += f'<path class="faint trace {side}" d="{outline}"/>'
        growing += _growing(outline, track, t, flat, side)
    distance = "near"
    if shadow:
        distance = "far"
    resting, moving = _arm(track, view, shadow, still), _arm(track, view, shadow, None)
    return (
        f'<svg class="arm {distance}" viewBox="0 0 {WIDTH:.0f} {view.height:.0f}" role="img" '
        f'aria-label="{label}">{scenery}'
        f'<g class="still">{resting}{desired}{full}</g><g class="moving">{moving}{desired}{faint}{growing}</g></svg>'
    )


def _points(flat: Array) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in flat.tolist())


def _outline(flat: Array) -> str:
    """A path with as few points as its shape needs."""
    low, high = flat.min(axis=0) - 1.0, flat.max(axis=0) + 1.0
    x, y = report_kit.joined(flat[:, 0], flat[:, 1], Window(low[0], high[0], low[1], high[1]))
    return "M" + " ".join(f"{a:.1f} {b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))


def _ground(track: Track) -> float:
    """Height of the floor: z = 0 if the whole arm is above it, else a little below the arm. [m]"""
    lowest = float(track.frames[..., 2].min())
    if lowest > 0.2:
        return 0.0
    return lowest - 0.3


def _floor(track: Track) -> Array:
    """Corners of the floor, (4, 3)."""
    points = np.concatenate([track.frames.reshape(-1, 3), track.desired])[:, :2]
    (a, b), (c, d) = points.min(axis=0) - 0.15, points.max(axis=0) + 0.15
    z = _ground(track)
    return np.array([[a, b, z], [c, b, z], [c, d, z], [a, d, z]])


def _scenery(track: Track, view: View) -> str:
    """Floor with its tiles, and the pedestal."""
    corners, base = _floor(track), track.frames[0, 0]
    low, high = corners[0], corners[2]
    tiles = []
    for axis in (0, 1):
        for value in np.arange(np.ceil(low[axis] / TILE) * TILE, high[axis], TILE):
            ends = np.array([low, high])
            ends[:, axis] = value
            tiles.append("M" + _points(view(ends)).replace(" ", "L"))
    foot = np.array([base[0], base[1], low[2]])
    turn = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    ring = foot + FOOT * np.column_stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)])
    return (
        f'<polygon class="floor" points="{_points(view(corners))}"/><path class="floor-tiles" d="{"".join(tiles)}"/>'
        f'<polygon class="foot" points="{_points(view(ring))}"/>'
        f'<polyline class="post" stroke-width="{POST * view.scale:.1f}" '
        f'points="{_points(view(np.array([foot, base])))}"/>'
    )


def _arm(track: Track, view: View, shadow: bool, still: int | None) -> str:
    """Shadow, links with round ends, and joints: of one pose, or moving through all of them."""
    frames = track.frames
    if still is not None:
        frames = frames[still : still + 1]
    flat, parts = view(frames), []
    if shadow:
        # The shadow is the arm, pressed flat on the floor.
        below = frames.copy()
        below[..., 2] = _ground(track)
        parts.append(_polyline("shadow", view(below), 0.045 * view.scale, track))
    joints = frames.shape[1] - 1
    # Of an arm that nobody drew all links and joints look alike.
    links: Sequence[tuple[int, int, float]] = ((0, joints + 1, LINK),)
    knobs: Sequence[tuple[int, float]] = [(k, KNOB) for k in range(joints)]
    if joints == 7:
        links, knobs = LINKS, KNOBS
    for first, end, thickness in links:
        parts.append(_polyline("link", flat[:, first:end], thickness * view.scale, track))
    for joint, radius in knobs:
        place = flat[:, joint]
        parts.append(
            f'<circle class="knob" r="{radius * view.scale:.1f}" cx="{place[0, 0]:.1f}" cy="{place[0, 1]:.1f}">'
            f"{_moved(place, track)}</circle>"
        )
    return f'<g class="body">{"".join(parts)}</g>'


def _polyline(kind: str, flat: Array, width: float, track: Track) -> str:
    values = list(map(_points, flat))
    return (
        f'<polyline class="{kind}" stroke-width="{width:.1f}" points="{values[0]}">'
        f"{_animated('points', values, track)}</polyline>"
    )


def _tool_places(track: Track) -> list[Array]:
    """The desired path, and all traces of the tool."""
    places = [track.desired]
    for _, traced in track.traces.values():
        places.append(traced)
    return places


def _moved(place: Array, track: Track) -> str:
    """Motion of a circle, (K, 2)."""
    motion = ""
    for k, name in enumerate(("cx", "cy")):
        motion += _animated(name, [f"{value:.1f}" for value in place[:, k]], track)
    return motion


def _animated(attribute: str, values: Sequence[str], track: Track) -> str:
    # What stands still needs no animation.
    if len(set(values)) < 2:
        return ""
    start, end = track.frame_time[0], track.frame_time[-1]
    steps = np.diff(track.frame_time)
    key_times = ""
    # Uneven frames need their times; they are long, so even ones go without.
    if np.ptp(steps) >= 0.02 * float(np.mean(steps)):
        times = []
        for t in ((track.frame_time - start) / (end - start)).tolist():
            times.append(f"{t:.4f}".rstrip("0").rstrip("."))
        key_times = f' keyTimes="{";".join(times)}"'
    return (
        f'<animate attributeName="{attribute}" dur="{track.seconds:.2f}s" repeatCount="indefinite"{key_times} '
        f'values="{";".join(values)}"/>'
    )


def _growing(outline: str, track: Track, t: Array, flat: Array, side: str) -> str:
    """The trace as far as the tool has come, and a dot at its end."""
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(flat, axis=0).T))])
    # The trace grows by its length, as far as the tool has come.
    share = np.interp(track.frame_time, t, length / max(float(length[-1]), 1e-9))
    behind = _animated(
        "stroke-dashoffset", [f"{1.0 - value:.4f}" for value in share.tolist()], track
    )
    place = np.column_stack([np.interp(track.frame_time, t, flat[:, k]) for k in (0, 1)])
    return (
        f'<path class="trace {side}" pathLength="1" stroke-dasharray="1" d="{outline}">{behind}</path>'
        f'<circle class="tip {side}" r="5" cx="{place[0, 0]:.1f}" cy="{place[0, 1]:.1f}">'
        f"{_moved(place, track)}</circle>"
    )
