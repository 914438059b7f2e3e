"""Logs of anything: whatever bytes they have, they are compared and played, or refused in words."""

from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fieldrig import S, load
from fieldrig.errors import UsageError
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.replay import replay
from fieldrig_devices.replay.comparison import compare_logs

LAB = load(Path(__file__).parents[3] / "configs" / "lab.yaml", ("time=virtual",))

HEADS = st.sampled_from(
    [b"", b"\x05\x06\0\0\x08", b"\x85\x05\0\0\x08", b"\0\0\0\0\x02", b"\x05\x07\0\0\x01", b"\xe5\x07\0\0\x08",
     b"\x81\x01\0\x80\x01", b"\x05\x07\0\x40\x01", b"\x01\x01\0\0\0\0\x04", b"\0\x01\0\0\0\0\x04", b"\xff", b"\0"]
)  # fmt: skip
ENTRIES = st.builds(
    TraceEntry,
    st.integers(-S, 10 * S),
    st.sampled_from(["can0", "mb_tcp", "mb_rtu", "wires", "vcan7", ""]),
    st.sampled_from(["can", "modbus", "serial", "wires", "ring", "pamring", "nothing"]),
    st.sampled_from(["", "io", "drive", "tank", "plc", "10.0.0.1:502", "tcp:1"]),
    st.builds(bytes.__add__, HEADS, st.binary(max_size=10)),
)


@given(st.lists(ENTRIES, max_size=30), st.lists(ENTRIES, max_size=30))
def test_any_two_logs_are_compared(left: list[TraceEntry], right: list[TraceEntry]) -> None:
    with suppress(UsageError):  # neither has a message
        result = compare_logs(lambda: left, lambda: right)
        assert sum(row.left for row in result.rows) <= len(left)
    with suppress(UsageError):
        assert compare_logs(lambda: left, lambda: left).is_same


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@example([TraceEntry(0, "mb_tcp", "modbus", "drive", b"\0")])
@given(st.lists(ENTRIES, min_size=1, max_size=30))
def test_any_log_is_played_or_refused(log: list[TraceEntry]) -> None:
    with suppress(UsageError):  # the log has nothing of the devices of the lab
        assert replay(log, LAB).played <= len(log)
