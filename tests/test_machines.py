"""The settings of tests/support/machines.py are those that libraries obey; a machine without effect proves nothing."""

import json
import os
import subprocess
import sys

import pytest

import machines

PROBE = """
import json, os, time
import numpy, scipy.linalg, threadpoolctl
from dehyst import _native
blas = [one for one in threadpoolctl.threadpool_info() if one["internal_api"] == "openblas"]
print(json.dumps({
    "cores": sorted({one["architecture"].lower() for one in blas}),
    "threads": sorted({one["num_threads"] for one in blas}),
    "level": _native.engine_level(), "zone": time.tzname[0], "home": os.path.isdir(os.path.expanduser("~")),
}))
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", machines.MACHINES)
def test_a_machine_has_the_kernels_threads_and_level_that_it_says(name, tmp_path):
    machine = machines.MACHINES[name]
    if machine.needs - machines.processor():
        pytest.skip("this processor cannot be that machine")
    given = {key: value for key, value in machines.settings(machine, tmp_path).items() if value}
    environment = {key: value for key, value in os.environ.items() if key not in given} | given
    done = subprocess.run(
        [sys.executable, "-c", PROBE], env=environment, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["level"] == machine.level
    assert found["zone"] != "UTC" and not found["home"]
    assert found["cores"] in ([], [machine.core.lower()])  # [] where numpy has another BLAS
    assert found["threads"] in ([], [min(machine.threads, os.cpu_count() or 1)])


def test_every_numeric_file_exists():
    assert len(machines.files()) >= len(machines.NUMERIC)
