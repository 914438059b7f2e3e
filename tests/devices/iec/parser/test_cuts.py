"""A program that ends anywhere, as in an editor or after a transfer that broke off, has a message or compiles."""

import re
from contextlib import suppress
from pathlib import Path

import pytest

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.dialect import CODESYS, EDITION_3, EPAS_4, Dialect
from fieldrig_devices.iec.imports import read_source
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile

ROOT = Path(__file__).parents[4]
PROGRAMS = sorted(ROOT.glob("tests/devices/iec/programs/*.st"))[::15] + sorted(ROOT.glob("configs/programs/*.st"))
assert PROGRAMS
DIALECTS = (EPAS_4, EDITION_3, CODESYS)
_TOKEN = re.compile(r"\w+|[^\w\s]")
FARTHEST = 700
"""Characters of a program that are cut, so that the test does not take minutes."""


@pytest.mark.long
@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.name)
def test_a_program_may_end_behind_every_token(path: Path) -> None:
    text = path.read_text(encoding="utf-8")[:FARTHEST]
    for number, token in enumerate(_TOKEN.finditer(text)):
        with suppress(CompileError):
            source = SourceFile(path.name, text[: token.end()])
            compile_project([source], StandaloneHost(VirtualClock()), DIALECTS[number % 3])


@pytest.mark.long
@pytest.mark.parametrize("dialect", DIALECTS, ids=lambda dialect: dialect.name)
def test_a_program_may_end_at_every_character(dialect: Dialect) -> None:
    text = (ROOT / "configs/programs/lamp.st").read_text()
    for end in range(len(text)):
        read_source("a.st", text[:end], dialect)
