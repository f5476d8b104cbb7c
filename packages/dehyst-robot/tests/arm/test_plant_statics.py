"""Published numbers of muscle, volume and valve, against the plant."""

import numpy as np
import pytest
from scipy.optimize import brentq

from dehyst_robot._native import PneumaticJoint, muscle_force, muscle_volume, valve_flow
from plant_samples import AIR, BAR, BENCH, VALVE, muscle, parameters

CONTRACTIONS = np.array([0, 2, 5, 10, 15, 20, 25]) / 100
# Table F of the two published DMSP-40 maps, rows 1..6 bar gauge, computed once with other code.
TOOL = """1032 575 265 -24 -283 -500 -646 | 2064 1593 1217 722 215 -217 -510 | 3096 2612 2169 1469 713 65 -374
| 4128 3631 3121 2215 1211 348 -237 | 5160 4649 4072 2962 1709 631 -101 | 6192 5668 5024 3709 2207 913 36"""
TABLE_BENCH = """773 507 292 89 -71 -224 -376 | 1723 1386 1073 716 403 98 -206 | 2673 2264 1854 1342 878 420 -36
| 3623 3143 2635 1969 1352 742 134 | 4573 4022 3416 2595 1826 1064 304 | 5523 4900 4197 3221 2300 1386 474"""
MAPS = {
    "tool": ({}, TOOL, [9.5, 17.3, 20.6, 22.7, 24.1, 25.3]),
    "bench": (BENCH, TABLE_BENCH, [12.7, 21.6, 24.6, 26.1, 27.0, 27.6]),
}


def force(pressure_bar, kappa, **changes):
    p, k = np.broadcast_arrays(np.asarray(pressure_bar, float) * BAR, np.asarray(kappa, float))
    return muscle_force(
        muscle(**changes), np.ascontiguousarray(p.ravel()), np.ascontiguousarray(k.ravel())
    )


@pytest.mark.parametrize("name", MAPS)
def test_both_published_maps_give_their_table_of_forces(name):
    changes, table, _ = MAPS[name]
    expected = np.array([row.split() for row in table.split("|")], dtype=float)
    found = force(np.arange(1, 7)[:, None], CONTRACTIONS[None, :], **changes).reshape(6, 7)
    np.testing.assert_allclose(found, expected, rtol=0, atol=0.6)


@pytest.mark.parametrize("name", MAPS)
def test_free_contractions_are_those_of_the_literature(name):
    changes, _, expected = MAPS[name]
    found = [100 * brentq(lambda k, p=p: force(p, k, **changes)[0], 0.0, 0.35) for p in range(1, 7)]
    np.testing.assert_allclose(found, expected, atol=0.051)


def test_the_geometric_map_fitted_to_the_tool_is_near_it_where_the_muscle_pulls():
    a, b = 3 / np.tan(np.radians(25)) ** 2, 1 / np.sin(np.radians(25)) ** 2
    p, k = np.meshgrid(np.linspace(0.5, 6, 23), np.linspace(0, 0.25, 51))
    fitted = [1.0656, np.pi * 0.02**2, a, b, 1.1227, -3975.8, -290.8, 650.96]
    tool = force(p, k)
    off = (force(p, k, map=2, coefficient=fitted) - tool)[tool > 0]
    assert 60 < np.sqrt(np.mean(off**2)) < 100


def test_volumes_are_those_of_the_fibre_geometry():
    kappa = np.array([0, 0.05, 0.1, 0.15, 0.2, 0.25])
    volume, slope = muscle_volume(muscle(dead_volume=0.0), kappa)
    np.testing.assert_allclose(1e3 * volume, [0.503, 0.634, 0.742, 0.826, 0.889, 0.932], atol=6e-4)
    # V = l (b^2 - l^2)/(4 pi n^2) with 28.6 degrees and 40 mm: no cubic in sight.
    length, angle = 0.4, np.radians(28.6)
    fibre, turns = length / np.cos(angle), length * np.tan(angle) / (np.pi * 0.04)
    now = length * (1 - kappa)
    np.testing.assert_allclose(
        volume, now * (fibre**2 - now**2) / (4 * np.pi * turns**2), rtol=2e-4
    )
    step = 1e-6
    ahead, behind = (muscle_volume(muscle(), kappa + d)[0] for d in (step, -step))
    np.testing.assert_allclose(slope, (ahead - behind) / (2 * step), rtol=1e-8)


def rate(spool, gauge_bar):
    """dp/dt of a closed chamber of 0.77 l, in bar/s, with the bare valve."""
    valve = {**VALVE, "conductance": 2.75e-8, "leak": 0.0}
    p = np.asarray(gauge_bar, float) * BAR + AIR["ambient"]
    mdot = valve_flow(valve, AIR, np.full(p.size, spool), p)
    return 1.26 * 287 * 293 / 0.77e-3 * mdot / BAR


def test_filling_is_faster_than_exhausting_as_published():
    bars = np.arange(1.0, 6.0)
    np.testing.assert_allclose(-rate(-1.0, bars), [8.6, 13.4, 17.9, 22.4, 26.9], atol=0.06)
    filling = rate(1.0, bars)
    assert 35.5 < filling[0] < 36.5
    assert 26.5 < filling[-1] < 27.5
    assert np.all(np.diff(filling) <= 0)


def iso6358(valve, air, s, p):
    """The same law from its definition, one number at a time."""

    def psi(ratio):
        b = valve["ratio"]
        if ratio > 0.999:
            return psi(0.999) * (1 - ratio) / 0.001
        return 1.0 if ratio <= b else float(np.sqrt(1 - ((ratio - b) / (1 - b)) ** 2))

    def way(start, end):
        return start * psi(end / start) if start >= end else -end * psi(start / end)

    def opening(s):
        d, leak = valve["dead_band"], valve["leak"]
        return float(np.interp(s, [-1, -d, d, 1], [0, leak, leak, 1]))

    full = valve["conductance"] * air["reference_density"]
    return full * (opening(s) * way(air["supply"], p) - opening(-s) * way(p, air["ambient"]))


def test_the_flow_is_iso_6358_through_two_ways_that_both_leak_in_the_middle():
    s, p = (a.ravel() for a in np.meshgrid(np.linspace(-1, 1, 41), np.linspace(0.5e5, 8.5e5, 97)))
    p = np.concatenate([p, np.full(41, 7.9995e5)])
    s = np.concatenate([s, np.linspace(-1, 1, 41)])
    expected = [iso6358(VALVE, AIR, *pair) for pair in zip(s, p, strict=True)]
    np.testing.assert_allclose(valve_flow(VALVE, AIR, s, p), expected, rtol=1e-9, atol=1e-15)


def test_the_flow_grows_with_the_opening_and_falls_with_the_pressure():
    grid = np.linspace(-1, 1, 401)
    for p in np.linspace(1e5, 8e5, 15):
        assert np.all(np.diff(valve_flow(VALVE, AIR, grid, np.full(401, p))) >= 0)
    for s in np.linspace(-1, 1, 21):
        pressures = np.linspace(1e5, 8e5, 5001)
        assert np.all(np.diff(valve_flow(VALVE, AIR, np.full(5001, s), pressures)) <= 1e-18)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda p: p.pop("arm"), "missing key: arm"),
        (lambda p: p.update(arm=[[0.05]]), "arm must hold two lists"),
        (lambda p: p.update(arm=[[0.05], []]), r"arm\[1\] is empty"),
        (lambda p: p.update(arm=[[0.05], [-0.05] * 9]), r"arm\[1\] holds 9 numbers, at most 8 fit"),
        (lambda p: p.update(arm=[[0.05], [0.05]]), "q > 0 shortens muscle 1"),
        (lambda p: p["muscle"][1].pop("length"), r"missing key: muscle\[1\].length"),
        (
            lambda p: p["muscle"][0]["hysteresis"].update(kind=1),
            r"missing key: muscle\[0\].hysteresis.size",
        ),
        (lambda p: p["air"].update(suply=8e5), "unknown key: air.suply"),
        (lambda p: p["valve"][0].update(ratio=1.0), r"valve\[0\].ratio"),
        (lambda p: p["valve"][0].update(leak="much"), r"valve\[0\].leak must be a number"),
        (lambda p: p["muscle"][0].update(creep_time=[1.0]), r"creep_force holds 6 numbers"),
        (lambda p: p["muscle"][0].update(creep_branches=3), "creep_branches"),
        (lambda p: p["muscle"][0].update(coefficient=[1.0] * 5), r"map 0 takes 6"),
        (lambda p: p["muscle"][0].update(volume=[float("nan")] * 4), r"volume\[0\] must be finite"),
        (lambda p: p["muscle"][0].update(map=7), r"muscle\[0\].map must be an integer from 0 to 4"),
        (lambda p: p.update(valve=[p["valve"][0]]), "valve must be a list of two"),
        (lambda p: p.update(sensors=3), "sensors must be a dict"),
        (lambda p: p.update(substeps=0), "substeps must be an integer"),
        (lambda p: p["muscle"][0].update(dead_volume=-1e-5), "dead_volume must not be negative"),
    ],
)
def test_a_wrong_parameter_is_named(change, message):
    wrong = parameters()
    change(wrong)
    with pytest.raises(ValueError, match=message):
        PneumaticJoint(wrong, 1)
