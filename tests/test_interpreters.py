"""dehyst in a subinterpreter: refused in one sentence, at once, before anything can hang."""

import subprocess
import sys

import pytest

NAMES = (
    "import dehyst",
    "import dehyst._native",
    "from dehyst.models import PrandtlIshlinskii",
    "from dehyst import cli",
)
PROGRAM = """
import sys
try:
    import _interpreters as interpreters
except ImportError:
    import _xxsubinterpreters as interpreters
exec(sys.argv[1])
caught = "except ImportError as e:\\n    print(e); print('numpy' in sys.modules, flush=True)"
code = "import sys\\ntry:\\n    " + sys.argv[2] + "\\n" + caught
interpreters.run_string(interpreters.create(), code)
print("still here")
"""


@pytest.mark.parametrize("statement", NAMES)
@pytest.mark.parametrize(
    "before", ["pass", "import dehyst; dehyst.PrandtlIshlinskii([0.0], [1.0]).simulate([0.0, 1.0])"]
)
def test_a_subinterpreter_is_refused_with_what_to_do_instead(before, statement):
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, before, statement], capture_output=True, text=True, timeout=120, check=False
    )
    said, numpy, end = done.stdout.splitlines()
    assert "processes" in said and "main interpreter" in said and said.count(". ") == 0
    assert numpy == "False"  # it was not even begun
    assert end == "still here" and done.returncode == 0, done.stderr


def test_the_main_interpreter_is_not_refused():
    subprocess.run([sys.executable, "-c", "import dehyst; dehyst.PrandtlIshlinskii"], timeout=120, check=True)
