"""The pictures of the documentation, drawn from running rigs and from the tables of the code.

Every module of `scenes` has a table PICTURES: the name of a file in docs/pictures, and the function that draws it.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Final

FOLDER: Final = Path(__file__).parents[2] / "docs" / "pictures"
SCENES: Final = Path(__file__).parent / "scenes"


def pictures() -> Mapping[str, Callable[[], str]]:
    """All pictures by name."""
    found: dict[str, Callable[[], str]] = {}
    for module in sorted(SCENES.glob("*.py")):
        table: Mapping[str, Callable[[], str]] = import_module(f"tests.pictures.scenes.{module.stem}").PICTURES
        assert not found.keys() & table.keys(), module.name
        found |= table
    return found
