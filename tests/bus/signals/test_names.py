"""Names of the signals of wires; the encoded signals are those of the head of `codec.py`."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.config.rig_file import from_dict
from fieldrig.faults.note import FaultNote
from fieldrig.traces.names import Named, Namer, namer_of
from fieldrig_bus.signals import traced


@pytest.fixture(scope="module")
def name() -> Namer:
    return namer_of(
        from_dict({"time": "virtual", "buses": {"wires": {"kind": "wires.virtual"}}, "devices": {}}), "wires"
    )


@pytest.mark.parametrize(
    ("sent", "kind", "text"),
    [
        ('["tank.full",true,""]', "digital", "tank.full = True"),
        ('["tank.level",1.5,"m"]', "analog", "tank.level = 1.5 m"),
        ('["axis.encoder",7,"count",12,1.5,0.0]', "motion", "axis.encoder = 7 count, 1.5 count/s"),
        ('["pto.pulse","pulses",0,"count",0,20000,1,0,1,null,1,0,1,0,0]', "pulses",
         "pto.pulse = 0 count, 20000 Hz, without end"),
        ('["pwm.out","pwm",25,"%",0,10,1]', "PWM", "pwm.out = 25 %, 10 Hz"),
    ],
)  # fmt: skip
def test_a_signal_has_its_wire_its_value_and_its_unit(name: Namer, sent: str, kind: str, text: str) -> None:
    assert name(traced.decode(sent.encode()), "plant") == Named(kind, "plant", text)


def test_a_fault_says_what_it_did(name: Namer) -> None:
    assert name(FaultNote(3, "stuck"), "plant") == Named("fault", "plant", "fault 3: stuck")


@given(data=st.binary(max_size=60))
def test_what_is_a_signal_has_some_name(name: Namer, data: bytes) -> None:
    try:
        message = traced.decode(data)
    except ValueError:
        return
    assert isinstance(name(message, "x"), Named)
