"""A drive stores its parameters and not its set-points (1010h, 1011h), whatever access types its file gives them."""

from collections.abc import Callable
from pathlib import Path

import pytest
from single_drive_bench import SingleDriveBench

from fieldrig_devices.cia402 import EDS

SAVE, LOAD = 0x6576_6173, 0x6461_6F6C
FOLLOWING_WINDOW, CONTROL_WORD = 0x6065, 0x6040


@pytest.fixture
def file_with(tmp_path: Path) -> Callable[..., str]:
    """Write our EDS with other access types of objects that can be mapped."""

    def write(**access: str) -> str:
        text = EDS.read_text(encoding="utf-8")
        for key, kind in access.items():
            head, section = text.split(f"[{key.removeprefix('x')}]\n", 1)
            body, rest = section.split("\n\n", 1)
            lines = [line for line in body.splitlines() if not line.startswith(("AccessType", "PDOMapping"))]
            lines += [f"AccessType={kind}", "PDOMapping=1"]
            text = "\n".join([f"{head}[{key.removeprefix('x')}]", *lines, "", rest])
        path = tmp_path / "their-drive.eds"
        path.write_text(text, encoding="utf-8")
        return str(path)

    return write


@pytest.mark.parametrize("access", ["rw", "rww", "rwr"])
def test_a_parameter_is_saved_and_restored(file_with: Callable[..., str], access: str) -> None:
    bench = SingleDriveBench(eds=file_with(x6065=access))
    usual = bench.get(FOLLOWING_WINDOW)
    bench.put(FOLLOWING_WINDOW, 4_321).put(0x1010, SAVE, 1).send("000#81 05")
    assert bench.get(FOLLOWING_WINDOW) == 4_321
    bench.put(0x1011, LOAD, 1).send("000#81 05")
    assert bench.get(FOLLOWING_WINDOW) == usual


@pytest.mark.parametrize("access", ["rw", "rww"])
def test_a_set_point_is_not_saved(file_with: Callable[..., str], access: str) -> None:
    bench = SingleDriveBench(eds=file_with(x6040=access, x607A=access))
    bench.put(0x607A, 500).control(0x06).put(0x1010, SAVE, 1).send("000#81 05")
    assert (bench.get(CONTROL_WORD), bench.get(0x607A)) == (0, 0)
