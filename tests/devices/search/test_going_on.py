"""A search that goes on in its corpus plays only what is new, and ends as one that was never interrupted."""

import sqlite3
from pathlib import Path

import pytest
from lamp_search import HISTORY, TWO_BUGS, planted
from typer.testing import CliRunner

from fieldrig.errors import UsageError
from fieldrig_devices.search import rig_files
from fieldrig_devices.search.command import app
from fieldrig_devices.search.corpus import Corpus
from fieldrig_devices.search.crew import Bench, LocalCrew
from fieldrig_devices.search.eye import digest_of
from fieldrig_devices.search.memory import identity_of
from fieldrig_devices.search.outcome import Outcome, packed, unpacked
from fieldrig_devices.search.plan import load_plan
from fieldrig_devices.search.search import Limits, Search

pytestmark = [pytest.mark.lean, pytest.mark.long]


def searched(plan_file: Path, corpus: Corpus, most: int, identity: bytes = b"one", seed: int = 1) -> tuple[int, str]:
    """Return the number of runs that were played, and the last line of what the search reports."""
    plan, told = load_plan(plan_file), list[str]()
    with Bench(plan) as bench, LocalCrew(bench, 2) as crew:
        search = Search(plan, bench, crew, corpus, seed, identity=identity)
        search.go(["sweep", "archive", "swarm"], Limits(600.0, most), told.append)
    return search.runs, told[-1]


@pytest.mark.parametrize("bug", [HISTORY, TWO_BUGS], ids=["history", "two bugs"])
def test_a_search_in_parts_is_one_search(tmp_path: Path, bug: str) -> None:
    plan, parts, whole = planted(tmp_path, bug), Corpus(None), Corpus(None)
    assert searched(plan, parts, 40)[0] == 40
    assert searched(plan, parts, 30) == (30, "40 runs of earlier searches were not played again")
    assert searched(plan, parts, 20) == (20, "70 runs of earlier searches were not played again")
    searched(plan, whole, 90)
    assert parts.hash() == whole.hash()
    assert whole.findings()


def test_after_a_change_everything_is_played_again(tmp_path: Path) -> None:
    plan, corpus = planted(tmp_path, ""), Corpus(None)
    searched(plan, corpus, 20)
    assert searched(plan, corpus, 10, identity=b"other")[1].startswith("swarm: ")


def test_the_identity_is_that_of_plan_rig_and_programs(tmp_path: Path) -> None:
    file = planted(tmp_path, "")
    before = identity_of(load_plan(file), file)
    assert identity_of(load_plan(file), file) == before
    for name in ("plan.yaml", "rig.yaml", "lamp.st"):
        text = (tmp_path / name).read_text()
        (tmp_path / name).write_text(f"{text}\n")
        assert identity_of(load_plan(file), file) != before, name
        (tmp_path / name).write_text(text)
    assert identity_of(load_plan(file), file) == before


def test_the_command_goes_on_in_its_corpus(tmp_path: Path) -> None:
    words = ["run", str(planted(tmp_path, "")), "--strategy", "swarm", "--most", "5", "--corpus", str(tmp_path / "c")]
    assert "not played again" not in CliRunner().invoke(app, words).output
    assert "5 runs of earlier searches were not played again" in CliRunner().invoke(app, words).output


def test_corpora_without_outcomes_are_still_read(tmp_path: Path) -> None:
    file = tmp_path / "old.sqlite"
    Corpus(file).close()
    with sqlite3.connect(file) as store:
        store.execute("DROP TABLE outcome")
    Corpus(file).close()
    assert Corpus(file).outcome(b"none") is None


def test_an_outcome_comes_back_as_it_was_and_a_damaged_one_is_refused(tmp_path: Path) -> None:
    file, kept = tmp_path / "c.sqlite", Outcome((("p", 5, "w"),), "no", ("p",), b"12345678", b"\1\0" * 500, b"\1")
    corpus = Corpus(file)
    corpus.keep((b"key", kept))
    assert corpus.outcome(b"key") == kept
    corpus.close()
    for column, value in (("violations", "[[1]]"), ("states", b"123"), ("marks", b"12"), ("shrunk", "{")):
        with sqlite3.connect(file) as store:
            before = store.execute(f"SELECT {column} FROM outcome").fetchone()
            store.execute(f"UPDATE outcome SET {column} = ?", (value,))
        with pytest.raises(UsageError, match="is damaged: a row of outcome cannot be read"):
            Corpus(file).outcome(b"key")
        with sqlite3.connect(file) as store:
            store.execute(f"UPDATE outcome SET {column} = ?", before)
    assert len(unpacked(packed(bytes(1 << 25)))) == 1 << 22


def test_the_digest_of_a_state_depends_on_no_order() -> None:
    names = [f"wire{number}" for number in range(20)]
    assert digest_of(("wires", frozenset(names))) == digest_of(("wires", frozenset(reversed(names))))
    assert digest_of(("wires", frozenset(names))).hex() == "f115e4bd5ee32769"


def test_a_compiled_file_of_another_program_is_read_as_ever(tmp_path: Path) -> None:
    """The names of the files that pytest compiles are none of Python's; they belong to no rig."""
    file = tmp_path / "checks.cpython-311-pytest-9.2.0.pyc"
    file.write_bytes(b"ok")
    with rig_files._noting_files() as read, open(str(file), "rb") as content:  # noqa: PTH123 - as importers open files
        assert content.read() == b"ok"
    assert file not in read
