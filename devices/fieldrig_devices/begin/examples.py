"""The examples that `fieldrig new` copies: the rig files of `configs`, which the wheel contains in this package.

An example is a rig file, and the first sentence of its opening comment describes it.  Its variants (`lab-vcan.yaml`
extends `lab.yaml`), its test (`test_lab.py`), and every file that one of them names belong to it.  A rig file that is
added to the folder therefore appears in the menu by itself.
"""

import re
from collections.abc import Iterator, Mapping
from importlib.resources import files
from itertools import takewhile
from pathlib import Path, PurePosixPath
from typing import Any

from fieldrig.config.yaml_source import read
from fieldrig.text.source_text import decoded
from fieldrig_devices.pam.application_files import CAM_SUFFIX

SUFFIX = ".yaml"


def folder() -> Path:
    """Return the folder of the examples: in the installed package, or in the clone of an editable installation."""
    package = Path(str(files("fieldrig_devices")))
    packed = package / "examples"
    return packed if packed.is_dir() else package.parents[1] / "configs"


def menu() -> dict[str, str]:
    """Return the description of each example by name."""
    rigs = sorted(folder().glob(f"*{SUFFIX}"))
    return {rig.stem: _sentence(rig) for rig in rigs if not _is_variant(rig)}


def content_of(example: str) -> Mapping[PurePosixPath, bytes]:
    """Return the files of an example by path, the rig file first."""
    root = folder()
    rigs = [root / f"{example}{SUFFIX}", *sorted(root.glob(f"{example}-*{SUFFIX}"))]
    found: dict[Path, None] = {}
    for rig in (rig for rig in rigs if rig.stem == example or _is_variant(rig)):
        _follow(rig, found)
    test = root / f"test_{example.replace('-', '_')}.py"
    return {PurePosixPath(file.relative_to(root).as_posix()): file.read_bytes() for file in (*found, test)}


def _sentence(rig: Path) -> str:
    with rig.open(encoding="utf-8") as lines:
        comment = takewhile(lambda line: line.startswith("#"), lines)
        text = " ".join(line.removeprefix("#").strip() for line in comment)
    sentence, dot, _ = text.partition(". ")
    return sentence + dot.strip()


def _data(rig: Path) -> Any:
    return read(rig.read_text(encoding="utf-8"), rig.name).data


def _is_variant(rig: Path) -> bool:
    bases = _data(rig).get("extends", [])
    names = [bases] if isinstance(bases, str) else bases
    return any(rig.stem.startswith(f"{name.removesuffix(SUFFIX)}-") for name in names)


def _follow(file: Path, found: dict[Path, None]) -> None:
    """Add the file and, recursively, all files that it names."""
    if file in found:
        return
    found[file] = None
    if file.suffix == SUFFIX:
        for text in _texts(_data(file)):
            for name in (text, f"{text.partition(':')[0]}.py"):  # a file, or `kind: "press:Press"`
                named = folder() / name
                if named.is_file() and named.resolve().is_relative_to(folder().resolve()):
                    _follow(named, found)
    if file.suffix == ".pam":
        for profile in _profiles(file):
            _follow(profile, found)


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
