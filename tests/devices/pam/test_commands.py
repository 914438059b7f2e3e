"""`fieldrig pam check` and `fieldrig pam fmt`."""

import json
from pathlib import Path

from pam_programs import MACHINE
from typer.testing import CliRunner

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
