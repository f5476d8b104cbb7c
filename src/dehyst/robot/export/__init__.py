"""Joint controllers as code for a target."""

from dehyst.robot.export.joint import joint_subject

__all__ = ["joint_subject"]
