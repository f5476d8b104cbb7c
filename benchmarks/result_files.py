"""Files of results: ten digits of a number, and a line for each row of a table."""

import json
import math
from pathlib import Path
from typing import Any


def tidy(value: Any) -> Any:
    """Return a result with ten digits of every number, nothing that is infinite, and no warnings."""
    if isinstance(value, dict):
        return {str(key): tidy(item) for key, item in value.items() if key != "warnings"}
    if isinstance(value, list | tuple):
        return [tidy(item) for item in value]
    if isinstance(value, float):
        return float(f"{value:.10g}") if math.isfinite(value) else None
    return value


def save(path: Path, result: dict[str, Any]) -> None:
    """Write a result; the rows of each of its tables stand on a line each."""
    path.write_text(_text(tidy(result), expanded=2) + "\n", encoding="utf-8")


def _text(value: Any, expanded: int) -> str:
    """Return JSON whose outer levels have a line for each member, the others none."""
    if not expanded or not isinstance(value, dict | list) or not value:
        return json.dumps(value)
    if isinstance(value, dict):
        lines = [f"{json.dumps(key)}: {_text(item, expanded - 1)}" for key, item in value.items()]
        return "{\n" + ",\n".join(lines) + "\n}"
    return "[\n" + ",\n".join(_text(item, expanded - 1) for item in value) + "\n]"
