"""`fieldrig pam check`, `fmt`, `doc` and `run`."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from pam_ports import GROUP, VME
from pam_programs import HEADER, MACHINE
from typer.testing import CliRunner

from fieldrig.clock import S
from fieldrig.config.rig_file import load
from fieldrig.virtual.rig import Rig
from fieldrig_devices.pam.commands import app

WRONG = MACHINE + "TASK TSK_a; SEQUENCE SEQ_a; AXI_Blt <- stop; END_SEQUENCE END_TASK\n"


def run(*arguments: str | Path) -> tuple[int, str]:
    done = CliRunner().invoke(app, [str(argument) for argument in arguments])
    return done.exit_code, done.output


def test_check_lists_all_mistakes(tmp_path: Path) -> None:
    right, wrong = tmp_path / "right.pam", tmp_path / "wrong.pam"
    right.write_text(MACHINE)
    wrong.write_text(WRONG)
    assert run("check", right) == (0, f"{right} is right: 31 objects.\n")
    right.write_text("APPLICATION NAME = one V1.00; BASIC_PAM_CYCLE = 3; END\n")
    assert run("check", right) == (0, f"{right} is right: 1 object.\n")
    code, output = run("check", wrong)
    assert code == 2
    assert "AXI_Blt is not declared here" in output
    code, output = run("check", wrong, "--json")
    assert [found["hint"] for found in json.loads(output)] == ["Perhaps AXI_Belt is meant."]


def test_includes_stay_inside_the_folder(tmp_path: Path) -> None:
    folder = tmp_path / "project"
    folder.mkdir()
    (tmp_path / "secret.pam").write_text("INTERNAL FLAG_VAR IFV_Secret;")
    (folder / "part.pam").write_bytes("// Grüße\nINTERNAL FLAG_VAR IFV_Part;".encode("latin-1"))
    program = folder / "all.pam"
    program.write_text(f'{MACHINE}#include "part.pam"\n#include "../secret.pam"\n')
    code, output = run("check", program)
    assert code == 2
    assert output.count("there is no file") == 1


def test_fmt_writes_one_layout(tmp_path: Path) -> None:
    file = tmp_path / "a.pam"
    file.write_text("APPLICATION\nNAME=a V1.00;\n BASIC_PAM_CYCLE =3 ; // 1 ms\nEND\n")
    assert run("fmt", file, "--check") == (2, f"{file}: not formatted\n")
    assert run("fmt", file) == (0, f"{file}: formatted\n")
    assert file.read_text() == "APPLICATION\n  NAME = a V1.00;\n  BASIC_PAM_CYCLE = 3;  // 1 ms\nEND\n"
    assert run("fmt", file, "--check") == (0, "")


def test_fmt_writes_the_standard_input_to_the_standard_output() -> None:
    text = "APPLICATION\nNAME=a V1.00;\n BASIC_PAM_CYCLE =3 ; // 1 ms\nEND\n"
    done = CliRunner().invoke(app, ["fmt", "-"], input=text)
    assert done.exit_code == 0
    assert done.stdout == "APPLICATION\n  NAME = a V1.00;\n  BASIC_PAM_CYCLE = 3;  // 1 ms\nEND\n"
    done = CliRunner().invoke(app, ["fmt", "-"], input="no text of a PAM")
    assert (done.exit_code, done.stdout, done.stderr.partition(" ")[0]) == (2, "", "-:1:1:")


@pytest.mark.parametrize(
    ("data", "said"), [(b"\x00\xf7NODE\x10", "has no meaning here"), (b"time: real\nname: a\n", "no text of a PAM")]
)
def test_fmt_leaves_a_file_of_another_kind_as_it_is(data: bytes, said: str, tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_bytes(data)
    code, output = run("fmt", file)
    assert code == 2
    assert said in output
    assert file.read_bytes() == data


@pytest.mark.manual("PAMS-073")
def test_headers_writes_the_include_files_of_a_vme_master(tmp_path: Path) -> None:
    file = tmp_path / "printer.pam"
    file.write_text(HEADER + GROUP + VME)
    code, output = run("headers", file, "--into", tmp_path / "AGL")
    assert (code, output.count("written")) == (0, 3)
    crcs = (tmp_path / "AGL/PAM_VME.H").read_text()
    assert crcs.count("#define") == 11
    assert re.search(r"^#define DFI_MachRunning +0xE41C$", crcs, re.MULTILINE)
    assert re.search(r"^#define VME_CLASS_REAL 4$", (tmp_path / "AGL/VMECLASS.H").read_text(), re.MULTILINE)
    memory = (tmp_path / "AGL/PAM_DEF.H").read_text()
    assert re.search(r"^#define VME_FATAL_ERROR_INFO_2 +56$", memory, re.MULTILINE)
    assert re.search(r"^#define VME_END_INIT_IN +6$", memory, re.MULTILINE)


@pytest.mark.manual("PAMS-073", "PAMS-058", "PAMS-064")
def test_a_c_compiler_lays_the_memory_out(tmp_path: Path) -> None:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler: apt-get install gcc")
    (tmp_path / "printer.pam").write_text(HEADER + GROUP + VME)
    run("headers", tmp_path / "printer.pam", "--into", tmp_path)
    offsets = {"header_fifo_out": 10, "watchdog": 20, "synchro": 22, "cmd_port": 24, "fatal_error_panel": 44}
    fields = "\n".join(
        f'_Static_assert(offsetof(S_dual_vme, {field}) == {offset}, "{field}");' for field, offset in offsets.items()
    )
    includes = "".join(f'#include "{name}"\n' for name in ("PAM_DEF.H", "PAM_VME.H", "VMECLASS.H"))
    (tmp_path / "master.c").write_text(f"#include <stddef.h>\n{includes}{fields}\nint crc = DLI_MachHeadSpeed;\n")
    subprocess.run([compiler, "-Wall", "-Werror", "-c", "master.c"], cwd=tmp_path, check=True, timeout=60)


@pytest.mark.parametrize(("text", "said"), [(MACHINE, "has no VME DUALPORT"), (WRONG, "AXI_Blt is not declared here")])
def test_headers_needs_a_vme_dual_port(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "a.pam"
    file.write_text(text)
    code, output = run("headers", file, "--into", tmp_path)
    assert code == 2
    assert said in output
    assert not list(tmp_path.glob("*.H"))


COUNTING = (
    MACHINE
    + "TASK TSK_a; SPECS CYCLES = 1; END_SPECS EVENTS ON_EVENT SBI_Start XEQ_SEQUENCE SEQ_a; END_EVENTS SEQUENCE SEQ_a;"
    " LOOP CWV_Count <- CWV_Count + {step}; WAIT_TIME 100; END_LOOP !SBI_Start; END_SEQUENCE END_TASK\n"
)


def test_run_shows_the_variables_at_the_end(tmp_path: Path) -> None:
    file = tmp_path / "a.pam"
    file.write_text(COUNTING.format(step=1))
    code, output = run("run", file, "--set", "SBI_Start=true", "--watch", "CWV_Count", "--for", "1s", "--json")
    assert code == 0
    assert "No node is behind the objects" in output
    assert json.loads(output[output.index("{") :]) == {"CWV_Count": 10}
    code, output = run("run", file, "--for", "1s")
    assert (code, "IFV_Each[2]" in output) == (0, True)


def test_run_says_what_is_wrong(tmp_path: Path) -> None:
    file = tmp_path / "a.pam"
    file.write_text(COUNTING.format(step=2_000_000_000))
    code, output = run("run", file, "--set", "SBI_Start=1", "--for", "1s")
    assert code == 6
    assert "02..FFF2 an integer overflow in TSK_a.SEQ_a" in output
    for arguments in (["--set", "SBI_Start"], ["--set", "none=1"], ["--watch", "none", "--for", "1s"], []):
        assert run("run", file, *arguments)[0] == 2
    file.write_text(WRONG)
    assert run("run", file, "--for", "1s")[0] == 2


@pytest.mark.parametrize("arguments", [("--set", "SBI_Stat=1"), ("--watch", "SBI_Stat")])
def test_run_proposes_the_nearest_name(tmp_path: Path, arguments: tuple[str, str]) -> None:
    file = tmp_path / "a.pam"
    file.write_text(COUNTING.format(step=1))
    code, output = run("run", file, *arguments, "--for", "10ms")
    assert (code, "did you mean SBI_Start?" in " ".join(output.split())) == (2, True), output


def test_doc_lists_sequences_and_identifiers(tmp_path: Path) -> None:
    file, listing = tmp_path / "a.pam", tmp_path / "a.doc"
    file.write_text(COUNTING.format(step=1))
    code, output = run("doc", file)
    assert code == 0
    assert "  S001       4096" in output
    assert run("doc", file, "--out", listing) == (0, "")
    assert listing.read_text() == output
    file.write_text(WRONG)
    assert run("doc", file)[0] == 2


@pytest.mark.long
def test_check_reports_an_application_without_room(tmp_path: Path) -> None:
    file = tmp_path / "a.pam"
    file.write_text(MACHINE + "".join(f"COMMON WORD_VAR CWV_{number};\n" for number in range(4_200)))
    code, output = run("check", file)
    assert code == 2
    assert "expected at most 262144 bytes" in output


@pytest.mark.long
def test_rig_writes_the_nodes_that_an_application_declares(tmp_path: Path) -> None:
    labeller = Path(__file__).parents[3] / "configs/programs/labeller.pam"
    for file in (labeller, *labeller.parent.glob("*.cam")):
        shutil.copy(file, tmp_path)
    rig_file = tmp_path / "rig.yaml"
    assert run("rig", tmp_path / "labeller.pam", "--virtual", "--out", rig_file) == (0, "")
    with Rig(load(rig_file)) as rig:
        assert set(rig.config.devices) == {
            "pam", "nod_belt", "nod_knife", "nod_web", "nod_stack", "nod_panel", "nod_guide",
        }  # fmt: skip
        rig.run_until(S)
        assert rig.get("pam", "state") == "ports"  # the ring is as declared, and waits for a VME master
    code, output = run("rig", tmp_path / "labeller.pam")
    assert code == 0
    assert "after: [nod_belt, nod_knife, nod_web, nod_stack, nod_panel, nod_guide]" in output


@pytest.mark.parametrize(
    "file", sorted((Path(__file__).parents[3] / "configs/programs").glob("*.pam")), ids=lambda file: file.name
)
def test_the_shipped_applications_have_the_layout_of_fmt(file: Path) -> None:
    assert run("fmt", file, "--check") == (0, "")


def test_names_in_another_case(tmp_path: Path) -> None:
    file, rig_file = tmp_path / "mixed.pam", tmp_path / "rig.yaml"
    file.write_text(HEADER + "INTERNAL FLAG_VAR IFV_Go; TASK TSK_a; POWERON ifv_go <- set; END_POWERON END_TASK\n")
    orders = [["check"], ["doc"], ["run", "--for", "1ms"], ["rig", "--virtual", "--out", str(rig_file)]]
    for command, *options in orders:
        assert run(command, file, *options)[0] == 2
        assert run(command, file, *options, "--ignore-case")[0] == 0
    with Rig(load(rig_file)) as rig:
        rig.run_until(S)
        assert rig.get("pam", "IFV_Go") is True
    file.write_text(HEADER + GROUP + VME + "TASK TSK_a; POWERON pamdisplay <- 1; END_POWERON END_TASK\n")
    assert [run("headers", file, "--into", tmp_path, *options)[0] for options in ([], ["--ignore-case"])] == [2, 0]
