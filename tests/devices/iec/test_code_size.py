"""The limit of the program code (PD-311), and the report of the sizes (PD-032)."""

from dataclasses import replace

import pytest
from iec_program import program

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.compiler import compile_project
from fieldrig_devices.iec.limits import MAX_4, Limits
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile

LINE = "x := x * 3 + 1;\n"


def size_of(lines: int, limits: Limits = MAX_4) -> int:
    text = program("x : DINT;", LINE * lines)
    return compile_project([SourceFile("a.st", text)], StandaloneHost(VirtualClock()), limits=limits).code_size


@pytest.mark.long
@pytest.mark.manual("PD-311", "PD-032")
def test_more_code_than_the_controller_has_room_for_is_refused() -> None:
    assert MAX_4.code == 2 * 1024 * 1024  # manual 6025
    most = size_of(100)
    assert most > size_of(99)
    limits = replace(MAX_4, code=most)
    assert size_of(100, limits) == most
    with pytest.raises(CompileError, match=rf"bytes of code; expected at most {most}"):
        size_of(101, limits)
