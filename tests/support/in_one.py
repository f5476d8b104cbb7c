"""One test for many cases: it takes them all, and its message lists those that fail, each with what it said."""

import inspect

import pytest


def in_one(names, cases):
    """Let a test take each of these cases in one run, as `pytest.mark.parametrize` would in a run each.

    For cases that are quick and need no fixture of their own: folders and patches are shared by all of them.
    """
    names, rows = [name.strip() for name in names.split(",")], list(cases)
    rows = [(row,) for row in rows] if len(names) == 1 else rows

    def over(test):
        def taking_all(**fixtures):
            failed = []
            for row in rows:
                try:
                    test(**fixtures, **dict(zip(names, row, strict=True)))
                except (Exception, pytest.fail.Exception) as fault:
                    place = (
                        inspect.getinnerframes(fault.__traceback__)[1]
                        if fault.__traceback__.tb_next
                        else None
                    )
                    at = f"{place.filename}:{place.lineno}: " if place else ""
                    failed.append(
                        f"- {', '.join(f'{value!r:.60}' for value in row)}: {at}{fault!s:.600}"
                    )
            assert not failed, f"{len(failed)} of {len(rows)} cases fail:\n" + "\n".join(failed)

        signature = inspect.signature(test)
        others = [each for name, each in signature.parameters.items() if name not in names]
        taking_all.__signature__ = signature.replace(parameters=others)
        taking_all.__name__, taking_all.__doc__, taking_all.__module__ = (
            test.__name__,
            test.__doc__,
            test.__module__,
        )
        taking_all.pytestmark = list(getattr(test, "pytestmark", ()))
        return taking_all

    return over
