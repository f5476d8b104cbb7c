"""The compensator in a 1 kHz control loop, on a simulated actuator that is not a Prandtl-Ishlinskii model.

The actuator is of Bouc-Wen type (a differential equation, not a sum of plays) with a lag of 5 ms. It is logged once,
identified, and then driven through a motion it has not seen: by a linear feedforward alone, by the compensator alone,
and by each of them with a PI controller.
"""

import numpy as np

import dehyst

DT = 0.001  # [s]


class Actuator:
    """Output 2 u - h [um] of an input u [V]; h is the hysteresis, slow to follow like a real drive."""

    def __init__(self) -> None:
        self.u = self.h = self.y = 0.0

    def __call__(self, u: float) -> float:
        """Advance by DT and return the output."""
        du, self.u = u - self.u, u
        self.h += 0.8 * du - 0.06 * abs(du) * self.h - 0.02 * du * abs(self.h)
        self.y += DT / 0.005 * (2.0 * u - self.h - self.y)
        return self.y


def log_loops() -> dehyst.Recording:
    """Log slow loops that shrink, twice: one half is fitted, the other one held out."""
    time = np.arange(0.0, 80.0, 0.01)
    u = 40.0 * (1.0 - 0.8 * (time % 40.0) / 40.0) * np.sin(2.0 * np.pi * 0.2 * time)
    plant = Actuator()
    y = [[plant(value) for _ in range(10)][-1] for value in u]
    return dehyst.Recording(input=u, output=y, time=time, input_unit="V", output_unit="um")


def track(feedforward, gain: float) -> float:
    """Follow 50 um at 0.5 Hz for 8 s; return the rms error after the first second. [um]"""
    time = np.arange(0.0, 8.0, DT)
    wanted = 50.0 * np.sin(2.0 * np.pi * 0.5 * time) * np.linspace(1.0, 0.4, time.size)
    plant, measured, integral, errors = Actuator(), 0.0, 0.0, []
    for target in wanted.tolist():
        error = target - measured
        integral += 20.0 * gain * error * DT
        u = feedforward(target) + gain * error + integral  # driven by the wanted output, never by the measured one
        measured = plant(u)
        errors.append(error)
    return float(np.sqrt(np.mean(np.square(errors[1000:]))))


if __name__ == "__main__":
    fit = dehyst.identify(log_loops(), initial_state="rest")
    print(fit.verdict)
    slope = np.ptp(fit.recordings[0].output) / np.ptp(fit.recordings[0].input)
    for gain, name in ((0.0, "no feedback"), (0.3, "PI controller")):
        plain, compensated = (track(lambda y: y / slope, gain), track(fit.model.inverse().stepper(), gain))
        print(f"{name}: rms error {plain:.3f} um with a linear feedforward, {compensated:.3f} um with the compensator")
