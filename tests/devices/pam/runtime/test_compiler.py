"""Limits of an application, its listing, and the workspaces of its sequences."""

import pickle

import pytest
from pam_bench import OBJECTS, PamBench, sequence
from pam_programs import MACHINE

from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.pam.runtime.compiler import compile_application
from fieldrig_devices.pam.runtime.listing import identifiers, listing

WORKSPACES = """
APPLICATION NAME = spaces V12.34; BASIC_PAM_CYCLE = 6; DEFAULT_TASK_WORKSPACE = 3000; END
TASK Task1; SPECS CYCLES = 1; DEFAULT_SEQUENCE_WORKSPACE = 4000; END_SPECS
  SEQUENCE Task1Sequence1; SPECS WORKSPACE = 1000; END_SPECS END_SEQUENCE
  SEQUENCE Task1Sequence2; END_SEQUENCE
END_TASK
TASK Task2; SPECS CYCLES = 1; END_SPECS
  SEQUENCE Task2Sequence1; SPECS WORKSPACE = 1500; END_SPECS END_SEQUENCE
  SEQUENCE Task2Sequence2; END_SEQUENCE
END_TASK
"""


@pytest.mark.manual("PAMS-061")
def test_workspaces_of_the_manual() -> None:
    """Case T24, manual lines 9274 to 9311."""
    compiled = compile_application(WORKSPACES, "a.pam")
    assert [sequence.workspace for sequence in compiled.code.sequences()] == [1000, 4000, 1500, 3000]
    (default,) = compile_application(OBJECTS + sequence(""), "a.pam").code.sequences()
    assert default.workspace == 4096


@pytest.mark.manual("PAML-300", "PAMS-062")
def test_a_workspace_that_is_too_small_stops_the_application() -> None:
    text = sequence("n <- 1;").replace("\nSEQUENCE SEQ_a;", "\nSEQUENCE SEQ_a; SPECS WORKSPACE = 100; END_SPECS")
    bench = PamBench(sequence("").replace("TSK_a", "TSK_0") + text)
    bench.run()
    assert bench.errors == []
    bench["SBI_a"] = True
    bench.run()
    (code, details, said) = bench.messages[-1]
    used = bench.program.code.sequences()[1].used
    assert (code, details, said) == (
        "03..E02C",
        (2, 100, used),
        f"rt_kernel S002 WORKSPACE Allocated: 100 Used: {used}",
    )
    assert (bench.runtime.is_stopped, bench["n"]) == (True, 0)


def test_deeper_sequences_need_more_workspace() -> None:
    def used(statements: str) -> int:
        (found,) = compile_application(OBJECTS + sequence(statements), "a.pam").code.sequences()
        return found.used

    assert (
        used("n <- 1;") < used("n <- 1 + 2 * 3;") < used("LOOP LOOP IF f THEN n <- 1; END_IF END_LOOP f; END_LOOP f;")
    )


@pytest.mark.manual("PAML-013")
def test_an_application_has_at_most_256_kilobytes() -> None:
    text = MACHINE + "".join(f"COMMON WORD_VAR CWV_{number};\n" for number in range(4_200))
    with pytest.raises(CompileError) as caught:
        compile_application(text, "a.pam")
    (mistake,) = caught.value.mistakes
    assert "expected at most 262144 bytes" in str(mistake)
    assert mistake.line == 1


def test_all_mistakes_are_reported_at_once() -> None:
    with pytest.raises(CompileError) as caught:
        compile_application(OBJECTS + sequence("m <- 1; n <- f; AXI_Each <- stop;"), "a.pam")
    assert len(caught.value.mistakes) == 3


@pytest.mark.manual("PAML-011")
def test_listing() -> None:
    text = listing(compile_application(WORKSPACES, "a.pam"))
    assert text.startswith("APPLICATION spaces V 12.34\nBASIC_PAM_CYCLE 6 (2.000 ms)\nSIZE ")
    assert "  S003       1500     160  Task2.Task2Sequence1\n" in text
    assert "PAM TASK\n  ID (hex)  items  name\n   1 (0001)      1  Task1\n" in text


def test_compiler_identifiers_count_within_a_class() -> None:
    program = compile_application(OBJECTS, "a.pam").program
    assert dict(identifiers(program)["BINARY_INPUT"]) == {"SBI_a": 1, "SBI_b": 2, "SBI_c": 3}
    assert [ids["NOD_Io"] for ids in identifiers(program).values() if "NOD_Io" in ids] == [2]


def test_a_compiled_application_can_come_from_another_process() -> None:
    compiled = compile_application(OBJECTS + sequence("n <- 7;"), "a.pam", is_debugged=True)
    copy = pickle.loads(pickle.dumps(compiled))
    assert [one.name for one in copy.code.sequences()] == ["SEQ_a"]


@pytest.mark.manual("PAMS-009", "PAML-015")
def test_functions_of_earlier_releases_write_parameters() -> None:
    bench = PamBench(sequence("AXI_Each[all] <- travel_speed(720);"))
    bench.run()
    bench["SBI_a"] = True
    bench.run()
    assert bench.objects.orders == ["AXI_Each[1]:TRAVEL_SPEED <- 720", "AXI_Each[2]:TRAVEL_SPEED <- 720"]


def test_included_files_have_their_own_lines() -> None:
    part = "\n\n" + sequence("n <- 5 / w;")
    compiled = compile_application(OBJECTS + '#include "part.pam"\n', "a.pam", {"part.pam": part}.get)
    assert dict(compiled.texts) == {"a.pam": OBJECTS + '#include "part.pam"\n', "part.pam": part}
    (found,) = compiled.code.sequences()
    assert found.place.file == "part.pam"
    routine = compiled.code.routines[found.routine]
    assert compiled.code.place(routine.lines[0]) == ("part.pam", 6)
