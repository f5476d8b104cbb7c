"""Exports models, inverses and joint controllers as code for a target, with tests of that code."""

from dehyst.export.folder import Written, export, read_manifest
from dehyst.export.subject import Subject, subject_of
from dehyst.export.targets import TARGETS, Check
from dehyst.export.verification import verify

__all__ = [
    "TARGETS",
    "Check",
    "Subject",
    "Written",
    "export",
    "read_manifest",
    "subject_of",
    "verify",
]
