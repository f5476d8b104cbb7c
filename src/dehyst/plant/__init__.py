"""The simulated arm: parameters, physics of its joints and of its links, kinematics."""

from dehyst.plant.parameters import Robot, load_robot

__all__ = ["Robot", "load_robot"]
