"""The HTTP API of a page by its own OpenAPI document: its operations, and paths with names that the lab has."""

import re
from collections.abc import Iterator
from typing import Any, Final

from page_bench import PageBench

EXAMPLES: Final = {
    "name": "tank",
    "key": "level",
    "part": "can0",
    "number": "1",
    "ending": "log",
    "file": "main.st",
    "action": "stop",
}
BUS_PATHS: Final = ("/buses/", "/traces/")


async def described(page: PageBench) -> dict[str, Any]:
    """Return the document."""
    answer = await page.get("openapi.json", "look")
    assert answer.status == 200
    document: dict[str, Any] = answer.json
    return document


def operations(document: dict[str, Any]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield method, path and description of each operation."""
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield method.upper(), path, operation


def filled(path: str, **others: str) -> str:
    """Return a path of the document with names of the lab, or with `others`."""
    names = EXAMPLES | ({"name": "can0"} if path.startswith(BUS_PATHS) else {}) | others
    return re.sub(r"\{(\w+)\}", lambda parameter: names.get(parameter[1], "x"), path).removeprefix("/")
