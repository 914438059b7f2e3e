"""Command lines from any bytes: no byte is an error, and what follows noise is read."""

from hypothesis import example, given
from hypothesis import strategies as st
from modem_bench import ModemBench

from fieldrig_bus.telephone.message import check_sent
from fieldrig_devices.modem.commands import REGISTERS
from fieldrig_devices.modem.parser import Mistake, parse
from fieldrig_devices.modem.reader import CommandReader, Line, Repeat


def events_of(*portions: bytes) -> list[Line | Repeat]:
    reader = CommandReader(lambda _data: None, lambda number: REGISTERS[number].default)
    return [event for portion in portions for event in reader.feed(portion)]


def test_lines_may_come_in_any_portions() -> None:
    assert events_of(b"A", b"T", b"E", b"0\rat", b"q1\r") == [Line("E0"), Line("q1")]


def test_what_is_before_at_is_dropped() -> None:
    assert events_of(b"xyzAAT1\r\rTA/") == [Line("1"), Repeat()]


@given(st.binary(max_size=400), st.integers(0, 400))
def test_portions_do_not_matter(data: bytes, cut: int) -> None:
    assert events_of(data[:cut], data[cut:]) == events_of(data)


@given(st.text(st.characters(max_codepoint=127), max_size=60))
@example("S7=9999999")
@example("&Z9=" + "1" * 80)
@example("+MS=" + "," * 50)
@example('+MS="V34",1')
def test_every_line_has_items_of_which_only_the_last_may_be_a_mistake(body: str) -> None:
    items = parse(body)
    assert not any(isinstance(item, Mistake) for item in items[:-1])


lines = st.one_of(
    st.binary(max_size=40),
    st.lists(
        st.sampled_from(
            b"E0 Q1 Q0 V0 V1 X4 H1 H A O DT200 DP1,W@!2; Z &F &V S0=1 S3=66 S5=84 S12=0 S7? +MS=V22,0 +IPR=300 &W "
            b"&Z1=5 DL DS=1 I3 &K4 &D3 S2=43 ; ? =5".split(b" ")
        ),
        max_size=6,
    ).map(lambda parts: b"AT" + b"".join(parts) + b"\r"),
)


@given(st.lists(st.tuples(lines, st.integers(0, 4000)), max_size=12))
def test_a_modem_goes_on_after_any_bytes(said: list[tuple[bytes, int]]) -> None:
    bench = ModemBench()
    for data, pause_ms in said:
        bench.type(data).wait(pause_ms / 1000)
    for message in bench.said():
        check_sent(message)
    number = bench.modem.add_fault({"what": "power_off"})
    bench.modem.clear_fault(number)
    bench.wait(1).set().heard()
    again = ModemBench(bench.store)  # whatever it has stored, it can read
    end = bytes((again.modem._engine.interpreter.profile.registers[3],))
    again.type(end + b"AT&FE0Q0V1" + end).heard()
    assert again.type("ATS7?\r").heard().endswith("\r\n050\r\n\r\nOK\r\n")
