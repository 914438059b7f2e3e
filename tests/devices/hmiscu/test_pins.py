"""The pins of the blocks, against the manual's figures and tables of variables."""

import pytest

from fieldrig_devices.hmiscu.blocks.pins import WIDTHS
from fieldrig_devices.hmiscu.blocks.tables import BLOCK_TYPES
from fieldrig_devices.hmiscu.enumerations import ALIASES, ENUMERATIONS

# Block, inputs, outputs, as printed.
FIGURES = [
    ("PTOSimple", "ResetError DIS_AuxInput", "PTO_REF PTOError Moving Stopping Frequency Distance"),
    (
        "PTOMoveRelative",
        "PTO_REF_IN Execute Velocity Distance Acceleration Deceleration Direction",
        "PTO_REF_OUT Done Busy Active CommandAborted Error ErrID",
    ),
    (
        "PTOMoveVelocity",
        "PTO_REF_IN Execute Velocity Acceleration Deceleration Direction",
        "PTO_REF_OUT InVelocity Busy CommandAborted Error ErrID",
    ),
    ("PTOStop", "PTO_REF_IN Execute Deceleration", "PTO_REF_OUT Done Busy Error ErrID"),
    ("PTOGetParam", "PTO_REF_IN Execute Param", "PTO_REF_OUT Done Busy Error ErrID ParamValue"),
    ("PTOSetParam", "PTO_REF_IN Execute Param Param_Value", "PTO_REF_OUT Done Busy Error ErrID"),
    ("PTOGetDiag", "PTO_REF_IN Execute", "PTO_REF_OUT Done Busy Error ErrID PTODiag"),
    ("PWM", "EN_Enable F_Enable EN_Sync F_Sync Frequency Duty", "InFrequency Busy Error ErrID"),
]


@pytest.mark.manual("SCU-009", "SCU-057", "SCU-067", "SCU-074")
@pytest.mark.parametrize(("block", "inputs", "outputs"), FIGURES)
def test_a_block_has_the_pins_of_its_figure(block: str, inputs: str, outputs: str) -> None:
    assert [pin.name for pin in BLOCK_TYPES[block].inputs] == inputs.split()
    assert [pin.name for pin in BLOCK_TYPES[block].outputs] == outputs.split()


def test_there_are_no_other_blocks_and_every_type_has_a_width() -> None:
    assert list(BLOCK_TYPES) == [block for block, _, _ in FIGURES]
    assert {pin.type for block in BLOCK_TYPES.values() for pin in block.pins} == set(WIDTHS)


def test_a_pin_is_found_in_any_case_of_its_letters() -> None:
    assert BLOCK_TYPES["PWM"].pin("EN_SYNC").name == "EN_Sync"  # S-33
    with pytest.raises(KeyError):
        BLOCK_TYPES["PWM"].pin("Velocity")


@pytest.mark.manual("SCU-060", "SCU-092")
def test_the_enumerations_have_the_values_of_the_appendix() -> None:
    assert ENUMERATIONS == {
        "PTOPWM_ERR_TYPE": {
            "NO_ERROR": 0,
            "PTO_UNKNOW_REF": 1,
            "PTO_UNKNOW_PARAMETER": 2,
            "PTO_INVALID_PARAMETER": 3,
            "PTO_COM_ERROR": 4,
            "PTO_AXIS_ERROR": 5,
        },
        "PTO_DIRECTION": {"PTO_POSITIVE": 0, "PTO_NEGATIVE": 1, "PTO_CURRENT": 2},
        "PTO_PARAMETER_TYPE": {"PTO_START_FREQUENCY": 0, "PTO_STOP_FREQUENCY": 1},
    }


def test_every_other_spelling_leads_to_a_name_that_exists() -> None:
    names = {*ENUMERATIONS, "PTO_REF", *(member for members in ENUMERATIONS.values() for member in members)}
    assert set(ALIASES.values()) <= names
    assert not set(ALIASES) & names
