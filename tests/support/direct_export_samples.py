"""Direct inverses for the tests of exports: every kind of term, of schedule and of start."""

import numpy as np

from dehyst.models import DirectInverse, ModelCard, Schedule, SignalCard
from dehyst_robot.control import Adaptation

CARD = ModelCard(
    SignalCard("torque", "Nm", -60.0, 60.0),
    SignalCard("angle", "rad", -0.5, 0.5),
    {"verdict": "good for compensation"},
)
SCHEDULES = (
    Schedule("mean_pressure", 2e5, 4e5, "Pa"),
    Schedule("output", -0.4, 0.5, "rad"),
    Schedule("load", -8.0, 8.0, "Nm"),
)
QUICK = Adaptation(
    rate=5.0,
    memory=0.05,
    first_error=5.0,
    patience=0.02,
    rest=0.01,
    settling=0.1,
    disturbance_pole=30.0,
)


def direct_model(
    seed=0, stops=6, paths=3, creeps=2, schedules=1, past="unknown", coefficients=4, card=CARD
):
    """Return a direct inverse of a joint with random weights."""
    rng = np.random.default_rng(seed)
    chosen = SCHEDULES[:schedules]
    sets = max(1, 2 * schedules)
    return DirectInverse(
        radii=np.geomspace(0.004, 0.6, stops),
        stop_weights=rng.uniform(0, 60 / max(1, stops), (sets, stops)),
        path_lengths=np.geomspace(0.03, 1.0, paths),
        path_weights=rng.uniform(0, 5, (sets, paths)),
        time_constants=np.geomspace(0.05, 30.0, creeps),
        creep_weights=rng.uniform(0, 4, (sets, creeps)),
        polynomial=rng.uniform(-1, 1, (sets, coefficients)) * np.geomspace(1, 20, coefficients),
        viscous=rng.uniform(0, 2, sets),
        center=0.02,
        schedules=chosen,
        past=past,
        card=card,
    )


def random_direct(rng):
    """Return a direct inverse of random sizes."""
    return direct_model(
        int(rng.integers(2**31)),
        *(int(rng.integers(0, most)) for most in (8, 4, 4)),
        schedules=int(rng.integers(0, 4)),
        past=str(rng.choice(["unknown", "rest", "rising", "falling"])),
        coefficients=int(rng.integers(1, 9)),
    )


def random_adaptation(rng):
    """Return an adaptation in which every branch is taken now and then."""
    return Adaptation(
        rate=rng.uniform(0, 50),
        memory=float(rng.choice([0.0, 0.01, 0.1])),
        dead_zone=float(rng.choice([0.0, 0.5])),
        most_error=float(rng.choice([0.5, 30.0])),
        contact_ratio=float(rng.choice([0.0, 2.0, 4.0])),
        first_error=float(rng.choice([0.5, 20.0])),
        patience=float(rng.choice([0.0, 0.05])),
        rest=float(rng.choice([0.0, 0.005])),
        settling=float(rng.choice([0.0, 0.01])),
        lowest=float(rng.choice([0.0, 0.9])),
        highest=float(rng.choice([1.0, 1.2])),
        offset_limit=float(rng.choice([0.0, 1.0])),
        most_acceleration=float(rng.choice([0.5, 8.0])),
        disturbance_pole=float(rng.choice([0.0, 50.0])),
    )
