"""Each listing of the manual compiles, or is refused for its reason.

Listings that need no ring run in the other tests of this folder, with the results of the manual.
"""

import pytest
from pam_listings import ALL, DC_MOTOR, MACHINE, task

from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.pam.language.formatter import formatted
from fieldrig_devices.pam.language.items import Application
from fieldrig_devices.pam.language.parser import parse
from fieldrig_devices.pam.runtime.compiler import compile_application

NAME = "L-{:02}".format

# Listings as they are printed, with the mistake that the compiler finds in them.
REFUSED = {
    "L-06 [i] of another object is missing": (
        task("AXI_Axes[all]:TRAVEL_SPEED <- (IRV_Sp * 1.25 - 1);"),
        "IRV_Sp has several items",
    ),
    "L-15 a semicolon is missing": (
        "D7SEG_OUTPUT D7S_1; NODE = NOD_Desk; DIGITS = 1 ADDRESS = 1; END",
        "; is missing behind 1",
    ),
    "L-17 the name of the node lacks its beginning": (
        DC_MOTOR.format(node="ToolsIo", rest="BREAKING"),
        "ToolsIo is not declared here",
    ),
    "L-20 a semicolon is missing": (
        "AXES_SET AXS_a; AXIS = AXI_X; END" + task("AXS_a <- power_on"),
        "; is missing behind power_on",
    ),
    "L-22 an input is set (E-13)": (task("SBI_Stop <- set;"), "a BINARY_INPUT"),
    "L-43 ELSE IF needs an END_IF of its own": (
        task("IF IFV_1 THEN IFV_2 <- set; ELSE IF IFV_2 THEN IFV_1 <- set; END_IF"),
        "END_IF",
    ),
}


def test_there_are_49_listings() -> None:
    assert sorted(ALL) == list(range(1, 50))


@pytest.mark.manual("PAML-014")
@pytest.mark.parametrize("number", ALL, ids=NAME)
def test_listings_compile(number: int) -> None:
    compiled = compile_application(ALL[number], f"L-{number:02}.pam")
    assert isinstance(compiled.program.items[0], Application)


@pytest.mark.parametrize("number", ALL, ids=NAME)
def test_listings_mean_the_same_in_one_layout(number: int) -> None:
    assert parse(formatted(ALL[number]), "a")[0] == parse(ALL[number], "a")[0]


@pytest.mark.manual("PAML-011")
def test_the_first_listing_names_an_application_and_its_version() -> None:
    compiled = compile_application(ALL[1], "a.pam")
    assert (compiled.application.name, compiled.application.version, compiled.thirds) == ("my_applic", "1.00", 3)


@pytest.mark.manual("PAML-015")
@pytest.mark.parametrize(("number", "old"), [(17, "BREAKING"), (22, "travel_speed"), (26, "PERIOD"), (45, "POSITION")])
def test_listings_with_old_names_have_a_note(number: int, old: str) -> None:
    assert any(old in note.what for note in compile_application(ALL[number], "a.pam").notes)


@pytest.mark.parametrize("name", REFUSED)
def test_listings_with_misprints_are_refused(name: str) -> None:
    text, said = REFUSED[name]
    with pytest.raises(CompileError) as caught:
        compile_application(MACHINE + text, "a.pam")
    assert said in str(caught.value)


@pytest.mark.manual("PAML-003", "PAML-004", "PAML-005")
def test_kinds_of_systems() -> None:
    counts = [compile_application(ALL[number], "a.pam").layout for number in (2, 3, 19)]
    assert [layout.counts["NOD_K"] for layout in counts] == [1, 3, 3]
    assert [layout.groups.get("NOD_K") for layout in counts] == [None, None, "NGR_C"]
