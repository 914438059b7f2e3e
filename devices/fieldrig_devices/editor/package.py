"""The files of the extension: its code, the colours of the three languages, and the version of this package."""

import json
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

from fieldrig_devices.editor.grammars import GRAMMARS

MANIFEST: Final = "package.json"
COMMAND: Final = "installed.json"
"""The file of an installed extension that has the command of the fieldrig that installed it."""
_FOLDER: Final = Path(str(files("fieldrig_devices.editor"))) / "extension"


def manifest() -> dict[str, Any]:
    """Return the manifest of the extension, with the version of this package."""
    described: dict[str, Any] = json.loads((_FOLDER / MANIFEST).read_text(encoding="utf-8"))
    return {**described, "version": version("fieldrig")}


def extension_files(command: Sequence[str] = ()) -> Mapping[str, bytes]:
    """Return the files of the extension by their names.

    `command` is the command of the fieldrig that it starts if a folder of programs has none of its own.
    """
    own = {path.relative_to(_FOLDER).as_posix(): path.read_bytes() for path in sorted(_FOLDER.rglob("*.*"))}
    made = {f"grammars/{name}.tmLanguage.json": _json(grammar()) for name, grammar in GRAMMARS.items()}
    installed = {COMMAND: _json({"command": list(command)})} if command else {}
    return {**own, MANIFEST: _json(manifest()), **made, **installed}


def _json(value: Any) -> bytes:
    return json.dumps(value, indent=2, ensure_ascii=False).encode() + b"\n"
