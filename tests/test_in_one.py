"""A test of many cases runs every one of them, and says which ones failed, where and why."""

import pytest

from in_one import in_one


@pytest.mark.slow
@in_one("a, b", [(1, 1), (1, 2), (3, 4)])
def equal(a, b, seen):
    """Both are the same."""
    seen.append(a)
    assert a == b, f"{a} is not {b}"


def test_every_case_is_run_and_those_that_fail_are_listed_with_file_and_line():
    seen = []
    with pytest.raises(AssertionError) as fault:
        equal(seen=seen)
    assert seen == [1, 1, 3]
    assert str(fault.value).startswith("2 of 3 cases fail:\n- 1, 2: ") and "1 is not 2" in str(
        fault.value
    )
    assert "test_in_one.py:13: " in str(fault.value) and "- 3, 4: " in str(fault.value)


def test_marks_words_and_other_fixtures_stay():
    assert [mark.name for mark in equal.pytestmark] == [
        "slow"
    ] and equal.__doc__ == "Both are the same."
    in_one("a", [])(lambda a, tmp_path: 1 / 0)(tmp_path=None)


@in_one("number", range(3))
@in_one("name", ["x", "y"])
def test_cases_of_cases_take_fixtures(number, name, tmp_path):
    path = tmp_path / f"{name}{number}"
    path.touch()
    assert path.exists() and not (name == "y" and not (tmp_path / "x2").exists() and number == 2)
