"""The files that a rig file names: programs, register tables, plates and the rig files that it extends.

A text of the rig file that is the name of a file counts, from the folder of the file that has it, whatever its key is.
`kind: "press:Press"` names `press.py`.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from fieldrig.config.yaml_source import read_file
from fieldrig.text.source_text import decoded
from fieldrig_devices.pam.application_files import CAM_SUFFIX

SUFFIX: Final = ".yaml"


def named_files(rig: Path) -> list[Path]:
    """Return a rig file that is there, and all files that it and the YAML files among them name."""
    found: dict[Path, None] = {}
    _follow(rig, found)
    return list(found)


def _follow(file: Path, found: dict[Path, None]) -> None:
    if file in found or not file.is_file():
        return
    found[file] = None
    if file.suffix == SUFFIX:
        for text in _texts(read_file(file).data):
            for name in (text, f"{text.partition(':')[0]}.py"):  # a file, or `kind: "press:Press"`
                if _is_name(name):
                    _follow(file.parent / name, found)
    if file.suffix == ".pam":
        for profile in _profiles(file):
            _follow(profile, found)


def _is_name(text: str) -> bool:
    return bool(text) and len(text) <= 255 and text.isprintable()


def _profiles(application: Path) -> Iterator[Path]:
    """Yield the cam files beside a PAM application whose names, without the suffix, occur in its text."""
    words = set(re.findall(r"\w+", decoded(application.read_bytes())))
    yield from (file for file in sorted(application.parent.glob(f"*{CAM_SUFFIX}")) if file.stem in words)


def _texts(data: Any) -> Iterator[str]:
    if isinstance(data, str):
        yield data
    elif isinstance(data, dict | list):
        for value in data.values() if isinstance(data, dict) else data:
            yield from _texts(value)
