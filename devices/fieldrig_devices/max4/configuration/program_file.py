"""The program file DEFAULT.PRG: the sources of a project, which the controller compiles when it loads them.

The manual does not describe the file; ours is JSON: {"format": "IEC sources", "dialect": NAME, "files": [{"name": NAME,
"text": TEXT}, ...]}, with "resource": NAME if one of several resources runs. The code of the controller is generated
from it at each boot, so it needs no format of its own.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self

from fieldrig.outside.untrusted import MalformedError, field, items, read_json, typed
from fieldrig.text.source_text import decoded
from fieldrig_devices.languages.source_file import SourceFile

PROGRAM_FILE: Final = "\\DEFAULT.PRG"
FORMAT: Final = "IEC sources"
LONGEST: Final = 16 << 20
"""Largest file in bytes."""
MOST_FILES: Final = 1_000


@dataclass(frozen=True, slots=True)
class Container:
    """The content of DEFAULT.PRG."""

    files: tuple[SourceFile, ...]
    dialect: str
    resource: str = ""
    """The name of the RESOURCE that runs; empty if there is only one."""

    def encode(self) -> bytes:
        files = [{"name": source.name, "text": source.text} for source in self.files]
        resource = {"resource": self.resource} if self.resource else {}
        return json.dumps({"format": FORMAT, "dialect": self.dialect, **resource, "files": files}, indent=1).encode()

    @classmethod
    def decode(cls, data: bytes) -> Self:
        """Return the content of a file.  ValueError, saying what was expected, for any other bytes."""
        try:
            content = read_json(data, longest=LONGEST, deepest=4)
            if field(content, "format", str) != FORMAT:
                raise MalformedError(f"expected the format {FORMAT!r}")
            files = tuple(
                SourceFile(field(file, "name", str), field(file, "text", str))
                for file in items(field(content, "files", list), dict, MOST_FILES, "files")
            )
            resource = typed(content.get("resource", ""), str)
            return cls(files, field(content, "dialect", str), resource)
        except MalformedError as cause:
            raise ValueError(f"not a program file: {cause}") from cause


def source_of(path: Path) -> SourceFile:
    """Read a source of a project.  ValueError, with the name, for a file that is too long."""
    try:
        return SourceFile(path.name, decoded(path.read_bytes()), path)
    except ValueError as cause:
        raise ValueError(f"{path.name}: {cause}") from cause
