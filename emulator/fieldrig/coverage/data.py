"""Coverage as a file of its own, so that several runs can be added up."""

import json
from typing import Final

from fieldrig.coverage.places import News, Place
from fieldrig.coverage.summary import Coverage

FORMAT: Final = "fieldrig coverage 1"


def written(coverage: Coverage) -> bytes:
    """Return the file: JSON with each place and whether it has run."""
    places = [[*place, has_run] for place, has_run in coverage.news]
    rows = ",\n".join(json.dumps(one) for one in places)
    return f'{{"format": "{FORMAT}", "places": [\n{rows}\n]}}\n'.encode()


def read(data: bytes) -> News:
    """Return what `written` has written.  ValueError for anything else."""
    try:
        content = json.loads(data)
        if content["format"] != FORMAT:
            raise ValueError(f"its format is {content['format']!r}: expected {FORMAT!r}")
        return tuple((_place(fields), bool(has_run)) for *fields, has_run in content["places"])
    except (LookupError, TypeError, RecursionError, UnicodeDecodeError, json.JSONDecodeError) as cause:
        raise ValueError("it is no file of coverage") from cause


def _place(fields: list[object]) -> Place:
    if len(fields) != len(Place._fields):
        raise ValueError(f"a place of it has {len(fields)} values: expected {len(Place._fields)}")
    place = Place.read(fields)
    texts, numbers = (place.file, place.pou, place.what), (place.line, place.column, place.of)
    if not all(isinstance(one, str) for one in texts) or not all(type(one) is int for one in numbers):
        raise ValueError("a place of it has a value of another type")
    return place
