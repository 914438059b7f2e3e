"""A value as YAML would have it, for messages.  It stands apart from pydantic, which most commands need not import."""

import json
from typing import Any, Final

LONGEST: Final = 60


def show(value: Any) -> str:
    """Return a value as YAML would have it, shortened."""
    text = json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
