"""Values in one line of YAML, as the written rigs and register tables have them."""

import json
import re
from collections.abc import Mapping
from typing import Any

_WORDS = ("true", "false", "null", "yes", "no", "on", "off", "y", "n")


def flow(value: Any) -> str:
    """Return a value of JSON in one line of YAML, with quotes only where they are needed."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{flow(key)}: {flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(flow, value))}]"
    is_plain = isinstance(value, str) and re.fullmatch(r"[A-Za-z_][A-Za-z0-9_-]*", value) is not None
    return value if is_plain and value.lower() not in _WORDS else json.dumps(value, ensure_ascii=False)
