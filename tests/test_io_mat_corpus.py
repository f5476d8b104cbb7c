"""MATLAB's own files of twenty years, as shipped with scipy's tests: read like scipy reads them, or refused by name."""

import warnings
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from dehyst.errors import DehystError
from dehyst.io.formats import read_table

FOLDER = Path(scipy.io.__file__).parent / "matlab" / "tests" / "data"
FILES = sorted(FOLDER.glob("*.mat"))

pytestmark = pytest.mark.skipif(not FILES, reason="this build of scipy ships no MATLAB files")


def vectors(path: Path) -> dict[str, np.ndarray]:
    """Real numeric vectors of a file by scipy, or nothing where scipy refuses."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            content = scipy.io.loadmat(path)
    except Exception:  # any refusal of the oracle means that there is nothing to compare
        return {}
    return {
        name: value.ravel().astype(float)
        for name, value in content.items()
        if not name.startswith("__")
        and isinstance(value, np.ndarray)
        and value.dtype.kind in "fiub"
        and value.ndim == 2
        and min(value.shape) == 1
        and value.size > 1
    }


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_file_of_matlab_is_read_like_scipy_reads_it_or_refused_by_name(path: Path) -> None:
    expected = vectors(path)
    try:
        columns = read_table(path).columns
    except DehystError:
        assert not expected
        return
    for name, values in expected.items():
        np.testing.assert_array_equal(columns[name], values)


def test_the_comparison_is_not_vacuous() -> None:
    assert sum(len(vectors(path)) for path in FILES) >= 10
