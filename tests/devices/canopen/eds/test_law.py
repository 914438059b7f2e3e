"""`fieldrig eds check` and `fieldrig check` report the same findings for the same file, however odd it is."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from canopen_bench import IO32
from eds_oddities import DEVICE_TYPE, MISTAKES, ODD, WRONG
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from fieldrig.cli.app import app

TEXT = IO32.read_text()
REFUSED = re.compile(r"[^\n]*device.eds:(\d+): (error|warning): ([^\n]*)")

Named = set[tuple[int, str]]
"""Findings as line and text."""


def run(*arguments: object) -> Any:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def named_by_eds_check(paths: list[Path]) -> dict[Path, Named]:
    named: dict[Path, Named] = {path: set() for path in paths}
    for line in run("eds", "check", "--json", *paths).stdout.splitlines():
        finding = json.loads(line)
        named[Path(finding["file"])].add((finding["line"], said(finding)))
    return named


def said(finding: dict[str, Any]) -> str:
    place = " ".join(part for part in (f"[{finding['section']}]" if finding["section"] else "", finding["key"]) if part)
    return f"{place + ': ' if place else ''}{finding['what']}; {finding['remedy']}"


def named_by_check(paths: list[Path]) -> dict[Path, Named]:
    """Return the findings of `fieldrig check` for a rig with a node for each file, each on a bus of its own."""
    rig = paths[0].parents[1] / "rig.yaml"
    buses = "".join(f"  can{number}: {{kind: can.virtual}}\n" for number in range(len(paths)))
    nodes = "".join(
        f"  io{number}: {{kind: canopen.node, node_id: 5, eds: {path}, links: {{can: can{number}}}}}\n"
        for number, path in enumerate(paths)
    )
    rig.write_text(f"time: virtual\nbuses:\n{buses}devices:\n{nodes}")
    named: dict[Path, Named] = {path: set() for path in paths}
    for mistake in json.loads(run("check", "--json", rig).stdout):
        if mistake.get("severity") == "warning":
            key = f"{mistake['key']}: " if mistake["key"] else ""
            named[Path(mistake["file"])].add((mistake["line"], f"{key}{mistake['what']}; {mistake['remedy']}"))
        else:
            number = re.fullmatch(r"devices\.io(\d+)\.eds", mistake["key"])
            assert number is not None, mistake
            named[paths[int(number[1])]] = {(int(line), rest) for line, _, rest in REFUSED.findall(mistake["what"])}
    return named


def write(folder: Path, texts: list[str]) -> list[Path]:
    paths = [folder / str(number) / "device.eds" for number in range(len(texts))]
    for path, text in zip(paths, texts, strict=True):
        path.parent.mkdir()
        path.write_text(text)
    return paths


FILES = [
    *(DEVICE_TYPE + text for text, _, _ in ODD),
    *(DEVICE_TYPE + text for text, _ in WRONG),
    *(TEXT.replace(right, wrong, 1) for right, wrong, _ in MISTAKES),
    TEXT,
    "",
]


@pytest.mark.long
def test_both_checks_name_the_same(tmp_path: Path) -> None:
    paths = write(tmp_path, FILES)
    by_check, by_eds_check = named_by_check(paths), named_by_eds_check(paths)
    for path, text in zip(paths, FILES, strict=True):
        assert by_check[path] == by_eds_check[path], text


lines = TEXT.splitlines()
EDITS = st.tuples(st.integers(0, len(lines) - 1), st.sampled_from(["", "=", "x", "0x", "[2000]", "-1", "$NODEID"]))


@settings(max_examples=10, deadline=None)
@given(st.lists(st.lists(EDITS, min_size=1, max_size=30), min_size=1, max_size=5))
@pytest.mark.long
def test_both_checks_name_the_same_of_any_file(
    tmp_path_factory: pytest.TempPathFactory, files: list[list[tuple[int, str]]]
) -> None:
    texts: list[str] = []
    for edits in files:
        changed = list(lines)
        for number, value in edits:
            changed[number] = f"{changed[number].partition('=')[0]}={value}"
        texts.append("\n".join(changed))
    paths = write(tmp_path_factory.mktemp("eds"), texts)
    assert named_by_check(paths) == named_by_eds_check(paths)


def test_warnings_come_with_file_line_and_key_and_refuse_nothing(tmp_path: Path) -> None:
    (path,) = write(
        tmp_path, [TEXT.replace("OrderCode=IO32\n", "").replace("FileName=io32.eds", "FileName=device.eds")]
    )
    named_by_check([path])
    line = path.read_text().splitlines().index("[DeviceInfo]") + 1
    done = run("check", tmp_path / "rig.yaml")
    assert done.exit_code == 0
    assert f"warning: {path}:{line}: [DeviceInfo] OrderCode: is missing\n    write OrderCode=" in done.stderr
    assert "rig.yaml has no mistakes" in done.stdout
