"""Whatever a master writes, the drive goes on: any objects, values and modes, with any file or personality."""

from pathlib import Path
from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from single_drive_bench import SingleDriveBench

from fieldrig_devices.canopen.datatypes import Integer
from fieldrig_devices.canopen.variable import Variable
from fieldrig_devices.cia402.single.personality import Name

pytestmark = pytest.mark.long

NO_LIMITS = "[FileInfo]\n" + "".join(
    f"[{index:04X}]\nParameterName=x\nObjectType=7\nDataType={kind}\nAccessType=rw\nPDOMapping=0\nDefaultValue={start}\n"
    for index, kind, start in (
        (0x1000, 7, 0x192), (0x6040, 6, 0), (0x6041, 6, 0), (0x605A, 3, 0), (0x6060, 2, 0), (0x6061, 2, 0),
        (0x6065, 7, 0), (0x6072, 6, 0), (0x607A, 4, 0), (0x607F, 7, 0), (0x6081, 7, 0), (0x6083, 7, 0), (0x6084, 7, 0),
        (0x6098, 2, 0), (0x60C1, 4, 0), (0x60C2, 5, 0), (0x60FF, 4, 0), (0x6071, 3, 0), (0x6042, 3, 0), (0x60A9, 7, 0),
    )
)  # fmt: skip
"""A file without limits, in which every value is 0, and arrays are plain variables."""
AT_ONCE = {"boot_up_ms": 0, "sdo_answer_ms": 0, "sdo_answer_most_ms": 0, "loses_first_sdo": False}
"""Settings of a personality with which the drive answers in the same instant."""
CONTROL = (0x06, 0x07, 0x0F, 0x1F, 0x3F, 0x5F, 0x7F, 0x10F, 0x02, 0x00, 0x80)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("eds") / "bare.eds"
    path.write_text(NO_LIMITS)
    return path


def writable(bench: SingleDriveBench) -> list[Variable]:
    return [
        variable for variable in bench.node.dictionary
        if variable.access.is_writable and variable.index >= 0x6000 and isinstance(variable.type, Integer)
    ]  # fmt: skip


@pytest.mark.parametrize("is_bare", [False, True])
@settings(max_examples=12, deadline=None)
@given(data=st.data())
def test_it_goes_on(file: Path, is_bare: bool, data: st.DataObject) -> None:
    keys = {"eds": str(file)} if is_bare else {"switches": {"home": {"low": 1.0, "high": 2.0}}, "low_stop_rad": -9.0}
    personality = data.draw(st.sampled_from([None, *get_args(Name)]))
    bench = SingleDriveBench(**keys, personality=personality, behaviour=AT_ONCE)
    objects = writable(bench)
    for _ in range(20):
        variable = data.draw(st.sampled_from(objects))
        assert isinstance(variable.type, Integer)
        low, high = int(variable.type.low), int(variable.type.high)
        value = data.draw(st.sampled_from([0, 1, low, high]) | st.integers(low, high))
        bench.try_put(variable.index, value, variable.subindex)
        bench.try_put(0x6060, data.draw(st.integers(-4, 11)))
        for word in data.draw(st.lists(st.sampled_from(CONTROL), max_size=5)):
            bench.control(word).after(2)
    bench.after(20)
    assert bench.get(0x6041) >= 0
