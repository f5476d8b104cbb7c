"""Write a log of two axes that move each other, and a motion that is wanted of them.

python examples/two_axes.py stage.csv wanted.csv
"""

import sys

import numpy as np
from relay_rig import PERIOD, REFERENCE, logged, stage

from dehyst.io import write_csv

log, wanted = sys.argv[1:]
write_csv(log, logged(stage))
time = PERIOD * np.arange(REFERENCE.size)
write_csv(wanted, {"time_s": time, "x_mm": REFERENCE, "y_mm": -0.8 * REFERENCE[::-1]})
