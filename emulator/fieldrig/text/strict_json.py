"""Values as JSON for programs that are not ours: NaN and the infinities, which JSON does not have, as words."""

import json
from math import isfinite
from typing import Any


def strict_json(value: Any, *, ensure_ascii: bool = False, indent: int | None = None) -> str:
    """Return a value as JSON of RFC 8259.

    A number that is not finite becomes "nan", "inf" or "-inf".  Tools read such numbers and write none.
    """
    try:
        return json.dumps(value, ensure_ascii=ensure_ascii, indent=indent, allow_nan=False)
    except ValueError:
        return json.dumps(_in_words(value), ensure_ascii=ensure_ascii, indent=indent, allow_nan=False)


def _in_words(value: Any) -> Any:
    if isinstance(value, float):
        return value if isfinite(value) else str(value)
    if isinstance(value, dict):
        return {key: _in_words(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_in_words(item) for item in value]
    return value
