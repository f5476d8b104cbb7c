"""A measured map: static forces of a muscle DMSP-20 of 300 mm (Martens, Boblan, Actuators 6(4), 2017, appendix A).

Found in ModelComparison2.m. The muscle does not push: 0 means slack.

Examples
--------
>>> MEASURED_FORCE[MEASURED_PRESSURE == 600e3][0].tolist()
[1460.1, 1004.0, 714.8, 443.5, 188.1, 0.0]
"""

from __future__ import annotations

import numpy as np

MEASURED_LENGTH = np.array([0.296, 0.282, 0.267, 0.250, 0.237, 0.222])
"""(6,) [m]"""
MEASURED_PRESSURE = (
    np.array([110.0, 157.5, 197.5, 250.0, 312.5, 375.0, 450.0, 525.0, 600.0, 675.0]) * 1e3
)
"""(10,) gauge [Pa]"""
MEASURED_FORCE = np.array(
    [
        [179.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [300.2, 42.9, 0.0, 0.0, 0.0, 0.0],
        [402.5, 131.0, 27.7, 0.0, 0.0, 0.0],
        [543.4, 244.7, 122.0, 0.0, 0.0, 0.0],
        [708.8, 380.4, 221.0, 80.6, 0.0, 0.0],
        [870.9, 518.9, 328.0, 157.6, 0.0, 0.0],
        [1065.2, 676.4, 462.3, 252.1, 65.5, 0.0],
        [1268.9, 837.5, 587.8, 352.3, 124.7, 0.0],
        [1460.1, 1004.0, 714.8, 443.5, 188.1, 0.0],
        [1653.5, 1164.3, 840.7, 535.8, 253.3, 0.0],
    ]
)
"""(10, 6) [N]"""
# Everybody shares these arrays: nobody may change them.
for _table in (MEASURED_LENGTH, MEASURED_PRESSURE, MEASURED_FORCE):
    _table.flags.writeable = False
