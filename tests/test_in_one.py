"""A test of many cases runs every one of them, and says which ones failed, where and why."""

import pytest
from conftest import pytest_collection_modifyitems

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
    assert "test_in_one.py:14: " in str(fault.value) and "- 3, 4: " in str(fault.value)


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


class Case:
    """A collected case, as far as conftest.py asks about it."""

    def __init__(self, nodeid, *marks):
        self.nodeid, self.marks = nodeid, {mark.name: mark.mark for mark in marks}

    def get_closest_marker(self, name):
        return self.marks.get(name)

    def add_marker(self, name):
        self.marks[name] = getattr(pytest.mark, name).mark


@in_one(
    "cases, marks, places",
    [
        (10, [], [*range(10)]),
        (10, [pytest.mark.slow], [0, 9]),
        (10, [pytest.mark.spread(4)], [0, 3, 6, 9]),
        (10, [pytest.mark.slow, pytest.mark.spread(3)], [0, 4, 9]),
        (2, [pytest.mark.spread(4)], [0, 1]),
        (1, [pytest.mark.slow], [0]),
        (3, [pytest.mark.exhaustive], []),
    ],
)
def test_of_many_cases_both_ends_and_those_asked_for_are_run(cases, marks, places):
    collected = [Case(f"file::test[{k}]", *marks) for k in range(cases)]
    pytest_collection_modifyitems(collected)
    run = [k for k, case in enumerate(collected) if "exhaustive" not in case.marks]
    assert run == places
    assert all("slow" in case.marks for case in collected if "exhaustive" in case.marks)
