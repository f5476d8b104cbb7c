"""Logs of a simulated actuator with exactly one peculiarity, and which causes may be named for it."""

from itertools import pairwise

import numpy as np

import dehyst

STEP = 0.02
SIZE = 3000
RADII = np.array([0.0, 0.1, 0.25, 0.45, 0.7])
WEIGHTS = np.array([0.8, 0.25, 0.2, 0.2, 0.15])
TIME, CLOCK, ZERO, OTHER = "time", "clock", "zero", "other"


def strokes(rng, size=SIZE, seconds=(0.6, 2.5), sizes=(0.2, 1.0)):
    """Ramps to turning points of all sizes, at several speeds, with a rest now and then; the whole range first."""
    time, place = [0.0, 1.0, 2.5], [0.0, 1.0, -1.0]
    while time[-1] < size * STEP:
        to = rng.uniform(*sizes) * (-1.0) ** len(place)
        time.append(time[-1] + rng.uniform(*seconds))
        place.append(1.0 * np.sign(to) if rng.random() < 0.2 else to)
        if rng.random() < 0.25:
            time.append(time[-1] + rng.uniform(0.5, 2.0))
            place.append(place[-1])
    return np.interp(np.arange(size) * STEP, time, place)


def sine(size=SIZE, period=100, envelope=None):
    wave = np.sin(2.0 * np.pi * np.arange(size) / period)
    return wave if envelope is None else wave * envelope


def plays(x, wider=1.0, past=()):
    model = dehyst.PrandtlIshlinskii(RADII * wider, WEIGHTS)
    return model.simulate(np.concatenate([np.asarray(past, float), x]))[len(past) :]


def lagged(signal, constant):
    out, share = np.empty(signal.size), 1.0 - np.exp(-STEP / constant)
    level = signal[0]
    for k, value in enumerate(signal):
        level += share * (value - level)
        out[k] = level
    return out


def shifted(signal, samples):
    at = np.clip(np.arange(signal.size) - samples, 0, signal.size - 1)
    return signal[at]


def rung(signal, hertz, damping=0.02):
    """A second-order response, stepped exactly enough by many small steps."""
    many, w = 20, 2.0 * np.pi * hertz
    fine = np.interp(np.arange(signal.size * many) / many, np.arange(signal.size), signal)
    y, v, out, dt = fine[0], 0.0, np.empty(signal.size), STEP / many
    for k, target in enumerate(fine):
        v += dt * (w * w * (target - y) - 2.0 * damping * w * v)
        y += dt * v
        if k % many == 0:
            out[k // many] = y
    return out


def flag(x, gap=0.02, band=0.1):
    out, z, last = np.empty(x.size), 0.0, 0.0
    for k, u in enumerate(x):
        z = min(max(z + (u - last) / gap, -band), band)
        last = u
        out[k] = np.clip(u / gap, -1.0, 1.0) + 0.2 * u + z * min(1.0, abs(u) / gap)
    return out


def friction(x, size, gap=0.2):
    out, z, last = np.empty(x.size), 0.0, x[0]
    for k, u in enumerate(x):
        z = min(max(z + (u - last) / gap, -1.0), 1.0)
        last = u
        out[k] = size * z
    return out


def one(x, y, rng, noise=0.001, time=True):
    y = y + noise * np.ptp(y) * rng.standard_normal(y.size)
    return [dehyst.Recording(input=x, output=y, time=np.arange(x.size) * STEP if time else None)]


def runs(rng, of, values, size=900):
    """Runs of one motion, each at a value of a signal that nobody named."""
    x = strokes(np.random.default_rng(rng.integers(1 << 30)), size)
    records = []
    for value in values:
        records += one(x, of(x, value), rng)
    return records


CURVES = {
    "tanh 30": lambda x: np.tanh(30.0 * x),
    "tanh 10": lambda x: np.tanh(10.0 * x),
    "tanh off centre": lambda x: np.tanh(30.0 * (x - 0.4)),
    "square root": lambda x: np.sqrt(0.5 * (x + 1.0)),
    "logarithm": lambda x: np.log10(1e-3 + 0.5 * (x + 1.0)),
    "clipped": lambda x: np.clip(x, -0.5, 0.5),
    "dead zone": lambda x: x - np.clip(x, -0.1, 0.1),
}


def growing(rng, time=True, shape=plays):
    x = sine(1400, 100, np.geomspace(0.02, 1.0, 14).repeat(100))
    return one(x, shape(x), rng, time=time)


def of(answer, motion=strokes, **more):
    """A maker of one log: a motion, what answers to it, and noise."""

    def made(rng):
        x = motion(rng)
        return one(x, answer(x), rng, **more)

    return made


def at(values, answer):
    """A maker of runs of one motion, each at another value of what nobody named."""
    return lambda rng: runs(rng, answer, values)


def hum(x):
    return 0.05 * np.sin(2.0 * np.pi * 7.3 * STEP * np.arange(x.size))


def late_clock(rng):
    x = strokes(rng)
    return one(shifted(x, 8), plays(x), rng)


def even(rng):
    """Strokes of all sizes that all take the same time."""
    turns = [-1, 1, -1, 1, -1, 0.5, -0.7, 1, -1, 0.3, -0.3, 1, -0.5, 1, -1]
    legs = [np.linspace(a, b, 60, endpoint=False) for a, b in pairwise(turns)]
    return np.concatenate([*legs, [turns[-1]]])


# name -> (maker, causes that may be named)
KINDS = {
    "clean": (of(plays), set()),
    "clean, untimed": (of(plays, time=False), set()),
    "clean, one speed": (of(plays, lambda rng: sine(envelope=np.linspace(1.0, 0.2, SIZE))), set()),
    "backlash": (of(dehyst.PrandtlIshlinskii([0.0, 0.3], [0.01, 1.0]).simulate), set()),
    "friction, clockwise": (of(lambda x: x + friction(x, 0.3)), set()),
    "saturating": (of(lambda x: np.tanh(1.5 * plays(x))), set()),
    "dead time": (of(lambda x: shifted(plays(x), 8)), {TIME, CLOCK}),
    "clock ahead": (late_clock, {TIME, CLOCK}),
    "lag": (of(lambda x: lagged(plays(x), 0.15)), {TIME, CLOCK}),
    "creep": (of(lambda x: plays(x) + 0.3 * lagged(x, 0.8)), {TIME}),
    "viscous": (of(lambda x: plays(x) + 0.05 * np.gradient(x, STEP)), {TIME, CLOCK}),
    "zero drifts": (of(lambda x: plays(x) + np.linspace(0.0, 0.3, x.size)), {ZERO}),
    "zero steps": (of(lambda x: plays(x) + 0.15 * (np.arange(x.size) > 1700)), {ZERO}),
    "growing": (growing, set()),
    "growing, untimed": (lambda rng: growing(rng, time=False), set()),
    "growing flag": (lambda rng: growing(rng, shape=flag), set()),
    "growing flag, untimed": (lambda rng: growing(rng, time=False, shape=flag), set()),
    "growing friction": (
        lambda rng: growing(rng, shape=lambda x: x + friction(x, 0.3, 0.1)),
        set(),
    ),
    "flag": (of(flag), set()),
    "one loop": (of(plays, lambda rng: sine(400, 400)), set()),
    "two loops": (of(plays, lambda rng: sine(800, 400)), set()),
    "unknown past": (
        of(lambda x: plays(x, past=(1.0, -1.0, 1.0)), lambda rng: 0.4 * strokes(rng) - 0.5),
        set(),
    ),
    "unknown past, high": (
        of(lambda x: plays(x, past=(-1.0, 1.0)), lambda rng: 0.3 * strokes(rng)),
        set(),
    ),
    "loads": (at((0.0, 0.3, 0.6, 0.9), lambda x, v: plays(x) + v), {OTHER, ZERO}),
    "loads move sideways": (
        at((-0.4, -0.1, 0.2, 0.5), lambda x, v: np.tanh(2.0 * (plays(x) - v))),
        {OTHER, ZERO},
    ),
    "width by a voltage": (
        at((0.2, 0.5, 0.8, 1.2), lambda x, v: 0.2 * x + friction(x, v)),
        {OTHER},
    ),
    "lagging width": (at((0.3, 0.8, 1.3), lambda x, v: 0.4 * x + plays(x, v)), {OTHER}),
    "gain by a condition": (at((0.7, 1.0, 1.3), lambda x, v: v * plays(x)), {OTHER}),
    "equal runs": (at((1, 2, 3, 4), lambda x, v: plays(x)), set()),
    "noise": (of(plays, noise=0.03), set()),
    "hum": (of(lambda x: plays(x) + hum(x)), {OTHER}),
    "resonance": (of(lambda x: rung(plays(x), 6.0)), {TIME, CLOCK, OTHER}),
    **{f"{name}, even": (of(curve, even), set()) for name, curve in CURVES.items()},
    **{name: (of(curve), set()) for name, curve in CURVES.items()},
}

# What names a cause: code of a finding, or words of a sentence about the residual -> the cause.
CODES = {
    "output-late": CLOCK,
    "output-early": CLOCK,
    "rate-dependent": TIME,
    "drift": ZERO,
    "two-actuators": ZERO,
    "recordings-differ": OTHER,
    "spectral-peak": OTHER,
    "resonance": OTHER,
}
WORDS = {
    "one clock": CLOCK,
    "Log time stamps: models of creep": TIME,
    "(creep)": TIME,
    "knows creep": TIME,
    "knows the rate": TIME,
    "It creeps": TIME,
    "log longer rests": TIME,
    "zero of the sensor": ZERO,
    "Warm up": ZERO,
    "zeroed elsewhere": ZERO,
}


def named(fit):
    """Causes that findings and sentences of a fit name, with the words that name them."""
    found = [
        (cause, finding.code) for finding in fit.warnings if (cause := CODES.get(finding.code))
    ]
    for sentence in fit.residual.suggestions:
        found += [(cause, words) for words, cause in WORDS.items() if words in sentence]
    return found


def logs(kind, seed):
    maker, _ = KINDS[kind]
    return maker(np.random.default_rng([seed, list(KINDS).index(kind)]))


def false_causes(kind, fit):
    return [(cause, words) for cause, words in named(fit) if cause not in KINDS[kind][1]]
