"""Settings of the controller: the terminals of the models, and what is refused with its key."""

from typing import Any

import pytest
from pydantic import ValidationError

from fieldrig.settings import Claim, WrongSettingsError
from fieldrig_devices.hmiscu.settings import HmiscuSettings

PTO = {"mode": "pto"}
PWM = {"mode": "pwm"}


def wrong(data: dict[str, Any]) -> list[str]:
    """The keys that are refused, with the reason."""
    with pytest.raises(ValidationError) as refused:
        HmiscuSettings.model_validate(data)
    found = []
    for mistake in refused.value.errors():
        error = mistake["ctx"]["error"]
        assert isinstance(error, WrongSettingsError)
        path = ".".join(map(str, mistake["loc"]))
        found += [f"{path}{'.' if path else ''}{'.'.join(map(str, key.path))}: {key.what}" for key in error.wrong]
    return found


@pytest.mark.parametrize(
    ("model", "counts"),
    [
        ("HMISCU6A5", {"DI": 14, "FI": 2, "DQ": 8, "FQ": 2, "AI": 0, "TI": 0, "AQ": 0}),
        ("HMISCU8A5", {"DI": 14, "FI": 2, "DQ": 8, "FQ": 2, "AI": 0, "TI": 0, "AQ": 0}),
        ("HMISCU6B5", {"DI": 6, "FI": 2, "DQ": 6, "FQ": 2, "AI": 2, "TI": 2, "AQ": 2}),
        ("HMISCU8B5", {"DI": 6, "FI": 2, "DQ": 6, "FQ": 2, "AI": 2, "TI": 2, "AQ": 2}),
    ],
)
def test_each_model_has_its_terminals(model: str, counts: dict[str, int]) -> None:
    kinds = HmiscuSettings.model_validate({"model": model}).kinds
    assert {prefix: sum(name.startswith(prefix) for name in kinds) for prefix in counts} == counts


def test_a_terminal_that_the_model_lacks_is_refused_with_its_key() -> None:
    assert wrong({"terminals": {"AI0": "tank.level"}}) == ["terminals.AI0: HMISCU6A5 has no terminal AI0"]
    assert wrong({"model": "HMISCU6B5", "terminals": {"DI6": "start"}}) == [
        "terminals.DI6: HMISCU6B5 has no terminal DI6"
    ]


def test_an_analog_terminal_needs_its_range_and_a_digital_one_has_none() -> None:
    assert wrong({"model": "HMISCU6B5", "terminals": {"AI0": "tank.level"}}) == [
        "terminals.AI0: AI0 is an analog input"
    ]
    assert wrong({"terminals": {"DI0": {"wire": "start"}}}) == ["terminals.DI0: DI0 is a digital input"]


@pytest.mark.manual("SCU-004")
def test_pto_on_channel_0_and_pwm_on_channel_1_are_refused_at_the_key_of_channel_1() -> None:
    assert wrong({"channel_0": PTO, "channel_1": PWM}) == ["channel_1.mode: pwm is not possible here"]


@pytest.mark.manual("SCU-075")
def test_the_outputs_of_a_channel_are_dedicated_to_it() -> None:
    assert HmiscuSettings.model_validate({}).dedicated == set()
    assert HmiscuSettings.model_validate({"channel_1": PWM}).dedicated == {"FQ1"}
    assert HmiscuSettings.model_validate({"channel_0": PTO}).dedicated == {"FQ0", "FQ1"}


def test_inputs_of_pwm_channels_are_normal_inputs() -> None:
    settings = HmiscuSettings.model_validate({"channel_0": PWM, "pwm_inputs": {"enable_0": "DI5"}})
    assert (settings.pwm_input("enable_0"), settings.pwm_input("sync_0")) == ("DI5", "DI1")
    assert wrong({"pwm_inputs": {"sync_1": "FI0"}}) == ["pwm_inputs.sync_1: FI0 is not a normal input of HMISCU6A5"]


def test_the_unit_the_node_and_outputs_are_claimed_and_inputs_are_not() -> None:
    settings = HmiscuSettings.model_validate(
        {
            "model": "HMISCU6B5",
            "modbus": {"unit_id": 4},
            "can_slave": {"node_id": 9},
            "terminals": {"DI0": "start", "DQ1": "lamp", "AQ0": {"wire": "valve", "unit": "%", "high": 100.0}},
        }
    )
    assert list(settings.claims("scu")) == [
        Claim("modbus", "unit", 4, ("modbus", "unit_id")),
        Claim("can", "node-ID", 9, ("can_slave", "node_id")),
        Claim("wires", "wire", "lamp", ("terminals", "DQ1")),
        Claim("wires", "wire", "valve", ("terminals", "AQ0")),
    ]
