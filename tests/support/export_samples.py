"""Models for the tests of exports: small, with a card, a map or clockwise."""

import shutil
import subprocess

import numpy as np
import pytest

import dehyst
from dehyst.models import ModelCard, SignalCard

needs_make = pytest.mark.skipif(
    shutil.which("make") is None or shutil.which("cc") is None, reason="no make or compiler"
)


def make_check(folder, build):
    """Run the check of an exported folder."""
    command = ["make", "-s", "-C", str(folder), "check", f"BUILD={build}", "CFLAGS=-O1"]
    return subprocess.run(command, capture_output=True, text=True, check=False)


CARD = ModelCard(
    SignalCard("pressure", "bar", -1.0, 2.0),
    SignalCard("angle", "deg", -3.0, 5.0),
    {"verdict": "good for compensation"},
)


def play_model(card=CARD):
    return dehyst.PrandtlIshlinskii(
        [0.0, 0.1, 0.4, 0.9], [1.0, 0.5, 0.3, 0.4], 0.2, None, 0.5, card=card
    )


def mapped_model():
    bend = dehyst.MonotoneMap([-4.0, 0.0, 1.0, 6.0], [-3.0, 0.0, 1.5, 5.0])
    return dehyst.ModifiedPrandtlIshlinskii(play_model(), after_map=bend)


def stop_model():
    return dehyst.StopOperatorModel([0.0, 0.2, 0.5], [0.0, 0.6, 0.3], 0.4, card=CARD)


def falling_model():
    return dehyst.PrandtlIshlinskii([0.0, 0.3], [-1.0, -0.5], card=CARD)


def large_model(n=1200):
    rng = np.random.default_rng(0)
    return dehyst.PrandtlIshlinskii(
        np.linspace(0.0, 1.4, n), rng.uniform(0.0, 1.0, n) / n + (np.arange(n) == 0), card=CARD
    )


MODELS = {"play": play_model, "mapped": mapped_model, "stop": stop_model, "falling": falling_model}
