"""Mistakes at the command line that need no rig: what is said names what was typed, and what was expected."""

import pytest
from typer.testing import CliRunner

from fieldrig.cli.app import app
from fieldrig.errors import UsageError


@pytest.mark.parametrize(
    "words",
    [("check", ""), ("check", "x.yaml", " "), ("up", ""), ("up", "x.yaml", "--trace", ""), ("trace", "show", ""),
     ("trace", "convert", "x.log", ""), ("new", "--eds", ""), ("iec", "check", ""), ("pam", "check", ""),
     ("pam", "headers", ""), ("arp", "compile", ""), ("eds", "check", ""), ("nameplate", "show", "")],
    ids=" ".join,
)  # fmt: skip
def test_an_empty_text_is_no_path(words: tuple[str, ...]) -> None:
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 2
    assert "expected a path, got '" in done.output


@pytest.mark.parametrize("endpoint", ["foo", "", "tcp/127.0.0.1", "127.0.0.1:7447", "http://127.0.0.1:7447"])
def test_what_is_no_endpoint_is_not_asked_for_a_rig(endpoint: str) -> None:
    done = CliRunner().invoke(app, ["status", "--control", endpoint])
    assert isinstance(done.exception, UsageError)
    assert done.exception.what == f"{endpoint!r} is no endpoint"
    assert "tcp/127.0.0.1:7447" in done.exception.remedy


@pytest.mark.parametrize(("name", "why"), [("nofile", "No such file"), (".", "Is a directory")])
def test_a_trace_that_is_not_there_is_not_asked_for_its_format(name: str, why: str) -> None:
    done = CliRunner().invoke(app, ["trace", "show", name])
    assert isinstance(done.exception, UsageError)
    assert why in done.exception.what


@pytest.mark.parametrize(
    ("words", "right"),
    [(("devicse",), "devices"), (("conforn",), "conform"), (("trace", "shwo"), "show"), (("trace", "stast"), "stats"),
     (("iec", "chekc"), "check"), (("scenario", "rnu"), "run"), (("pam", "fmtt"), "fmt")],
)  # fmt: skip
def test_a_mistyped_command_is_answered_with_the_nearest_one(words: tuple[str, ...], right: str) -> None:
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 2
    assert f"No such command '{words[-1]}'. Did you mean '{right}'" in done.output
