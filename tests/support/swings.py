"""An oscillator that is solved exactly, for logs of actuators that ring."""

import numpy as np


def second_order(signal, frequency, damping, period):
    """Exact answer of 1/(1 + 2 zeta s/w + s^2/w^2) to a signal that is held between samples, from rest at its first."""
    w = 2.0 * np.pi * frequency
    pole = w * complex(-damping, np.sqrt(1.0 - damping**2))
    # y = u + Re(c z): each hold moves z by its own step of u.
    decay = np.exp(pole * period)
    c = -1.0 - 1j * pole.real / pole.imag
    z, y = 0j, np.empty(signal.size)
    last = signal[0]
    for k, u in enumerate(signal):
        y[k] = last + (z * c).real
        z = (z + (u - last)) * decay
        last = u
    return y
