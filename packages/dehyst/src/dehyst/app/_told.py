"""A progress bar that tells a function instead of drawing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rich.progress import Progress, TaskID


class Teller(Progress):
    """Calls ``listener(stage, done, of)`` at every update of a task."""

    def __init__(self, listener: Callable[[str, float, float | None], None]) -> None:
        super().__init__(disable=True)
        self.listener = listener

    def update(self, task_id: TaskID, **changed: Any) -> None:
        """Make the change, and tell the listener of it."""
        super().update(task_id, **changed)
        task = self._tasks[task_id]
        self.listener(task.description, task.completed, task.total)
