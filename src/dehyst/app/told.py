"""A progress bar that tells a function instead of drawing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rich.progress import Progress, TaskID


class Teller(Progress):
    """Calls ``told(stage, done, of)`` at every update of a task."""

    def __init__(self, told: Callable[[str, float, float | None], None]) -> None:
        super().__init__(disable=True)
        self.told = told

    def update(self, task_id: TaskID, **changed: Any) -> None:
        """Take the change over, and tell it."""
        super().update(task_id, **changed)
        task = next(each for each in self.tasks if each.id == task_id)
        self.told(task.description, task.completed, task.total)
