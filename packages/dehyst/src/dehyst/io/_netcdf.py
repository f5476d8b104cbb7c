"""Classic netCDF (version 3), by SciPy; netCDF-4 is HDF5. Attributes are applied as the CF conventions say."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from dehyst.io._collect import Collector
from dehyst.io._conventions import Attributes


def fill(collector: Collector, data: bytes, path: Path) -> None:
    """Add every variable of numbers."""
    from scipy.io import netcdf_file

    with netcdf_file(io.BytesIO(data), "r", mmap=False) as file:
        attributes = Attributes(collector)
        for name, variable in file.variables.items():
            stored = np.asarray(variable.data)
            if stored.dtype.kind in "if":
                attributes.add(name, stored, dict(variable._attributes), True)
        attributes.finish()
