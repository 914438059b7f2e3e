"""Arbitrary frames cause no exception, don't stop the heartbeat, and leave the dictionary as the answers say."""

import pytest
from canopen_bench import IO32, CanopenBench, show
from canopen_model import DictionaryModel, Frame
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.eds.reader import load

pytestmark = pytest.mark.long

IDS = [0x000, 0x080, 0x085, 0x185, 0x205, 0x285, 0x305, 0x585, 0x605, 0x701, 0x705, 0x7E5]
KEYS = [(variable.index, variable.subindex) for variable in load(IO32, 5)]

frames = st.builds(
    lambda identifier, data, remote: CanFrame(identifier, b"" if remote else data, is_remote=remote),
    st.sampled_from(IDS) | st.integers(0, 0x7FF),
    st.binary(max_size=8),
    st.booleans(),
)
commands = st.sampled_from(
    [0x40, 0x23, 0x2B, 0x2F, 0x22, 0x21, 0x20, 0x60, 0x70, 0x00, 0x01, 0x0D, 0x1D, 0x80, 0xA0, 0xA3, 0xA1, 0xC0, 0xC6]
)
small = st.sampled_from([0, 1, 2, 3, 4, 8, 255, 256, 0x8000_0000, 0x4000_0080, 0x6000_0108]) | st.integers(
    0, 0xFFFF_FFFF
)
sdo_requests = st.builds(
    lambda command, key, number: (
        bytes((command,)) + key[0].to_bytes(2, "little") + bytes((key[1],)) + number.to_bytes(4, "little")
    ),
    commands | st.integers(0, 255),
    st.sampled_from(KEYS) | st.tuples(st.integers(0, 0xFFFF), st.integers(0, 255)),
    small,
)


@settings(max_examples=200, deadline=None)
@given(st.lists(st.one_of(frames, sdo_requests.map(lambda request: CanFrame(0x605, request)))))
def test_no_frame_raises_and_the_heartbeat_goes_on(sent: list[CanFrame]) -> None:
    bench = CanopenBench(objects={"1017:00": 10})
    for frame in sent:
        bench.can.deliver(frame)
        bench.after(0.1)
    bench.send("000#81 05")
    assert bench.after(30).count("705#7f") == 3


@settings(max_examples=200, deadline=None)
@given(st.lists(sdo_requests, max_size=60))
def test_dictionary_is_what_the_answers_of_the_server_said(requests: list[bytes]) -> None:
    bench, model = CanopenBench(), DictionaryModel(IO32, 5, {})
    bench.take()
    for request in requests:
        bench.can.deliver(CanFrame(0x605, request))
        came = [Frame(0, frame.identifier, frame.data) for frame in bench.can.take()]
        model.went(Frame(0, 0x605, request), came)
    for (index, subindex), expected in model.expected():
        assert bench.node.dictionary.find(index, subindex).data == expected, f"{index:04X}:{subindex:02X}"


BLOCK_GOES_ON = {0xA0, 0xA2, 0xC0, 0xC1}
"""Answers in block transfers, after which the number of further answers depends on the state."""


@settings(max_examples=200, deadline=None)
@given(st.lists(sdo_requests, max_size=30))
def test_every_request_gets_one_answer_of_8_bytes_but_for_an_abort_and_within_blocks(requests: list[bytes]) -> None:
    bench = CanopenBench()
    bench.take()
    is_block = False
    for request in requests:
        bench.can.deliver(CanFrame(0x605, request))
        answers = [frame for frame in bench.can.take() if frame.identifier == 0x585]
        assert all(len(frame.data) == 8 for frame in answers)
        if not is_block:
            is_abort = request[0] >> 5 == 4
            assert len(answers) == (0 if is_abort else 1), [show(frame) for frame in answers]
        is_block = (bool(answers) and answers[-1].data[0] & 0xE3 in BLOCK_GOES_ON) or (is_block and not answers)
