"""Files of a corpus that cannot be used: each is refused in words, and stays as it is."""

import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from fieldrig.errors import UsageError
from fieldrig_devices.search.corpus import Corpus, Finding, Origin
from fieldrig_devices.search.corpus_file import CorpusFile
from fieldrig_devices.search.piece import Run


def changed(*statements: str) -> Callable[[Path], None]:
    def change(file: Path) -> None:
        with closing(sqlite3.connect(file)) as store, store:
            for statement in statements:
                store.execute(statement)

    return change


def made_of(content: bytes) -> Callable[[Path], None]:
    def change(file: Path) -> None:
        file.write_bytes(content)

    return change


def cut(file: Path) -> None:
    file.write_bytes(file.read_bytes()[:5_000])


NO_CORPUS, OTHER_VERSION = "is no corpus of a search", "is the corpus of another version of fieldrig"
TABLES = ("run", "finding", "plan", "covered", "outcome")
FILES = {
    "a text": (made_of(b"hello\n" * 400), NO_CORPUS),
    "no signs of a text": (made_of(bytes(range(256)) * 20), NO_CORPUS),
    "a part of a corpus": (cut, NO_CORPUS),
    "bookmarks": (changed(*(f"DROP TABLE {name}" for name in TABLES), "CREATE TABLE places (url TEXT)"), NO_CORPUS),
    "runs of others": (changed(*(f"DROP TABLE {name}" for name in TABLES), "CREATE TABLE run (name TEXT)"), NO_CORPUS),
    "more is known of a run": (changed("ALTER TABLE run ADD COLUMN cost REAL"), OTHER_VERSION),
    "less is known of a finding": (changed("ALTER TABLE finding DROP COLUMN reason"), OTHER_VERSION),
    "a further table": (changed("CREATE TABLE worker (name TEXT)"), OTHER_VERSION),
}


def kept(file: Path) -> None:
    """Write a corpus with a run."""
    with closing(Corpus(file)) as corpus:
        corpus.add(Run((), (), 5), "swarm")
        corpus.come_from(Origin("plan.yaml", "", ()))


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_is_no_corpus_of_this_version_stays_as_it_is(tmp_path: Path, name: str) -> None:
    change, what = FILES[name]
    file = tmp_path / "c.sqlite"
    kept(file)
    change(file)
    before = file.read_bytes()
    with pytest.raises(UsageError) as caught:
        Corpus(file)
    assert caught.value.what == f"{file} {what}"
    assert file.read_bytes() == before


def test_statistics_that_sqlite_keeps_itself_are_no_other_version(tmp_path: Path) -> None:
    file = tmp_path / "c.sqlite"
    kept(file)
    changed("ANALYZE")(file)
    with closing(Corpus(file)) as corpus:
        assert sum(1 for _ in corpus.runs()) == 1


def test_a_full_disk_is_said_and_what_was_kept_before_is_there(tmp_path: Path) -> None:
    file = tmp_path / "c.sqlite"
    kept(file)
    store = CorpusFile(file)
    with store.changing() as full:
        full.execute("PRAGMA max_page_count = 1")  # SQLite's own way to be out of space: no page more than there are
    with pytest.raises(UsageError, match="cannot be used any more: database or disk is full"), store.changing() as full:
        full.executemany("INSERT INTO plan VALUES (?, '', '')", [("x" * 1_000 + str(n),) for n in range(100)])
    store.close()
    with closing(Corpus(file)) as corpus:
        assert sum(1 for _ in corpus.runs()) == 1
        assert corpus.origins() == [Origin("plan.yaml", "", ())]


def test_a_finding_that_is_made_small_again_keeps_its_number(tmp_path: Path) -> None:
    with closing(Corpus(tmp_path / "c.sqlite")) as corpus:
        for name in ("a", "b", "c"):
            corpus.note(Finding(0, name, (), (), 5, 1, "is true"))
        first = corpus.findings()[0]
        corpus.replace(first.number, first._replace(what="is false"))
        assert [(one.number, one.property, one.what) for one in corpus.findings()] == [
            (1, "a", "is false"),
            (2, "b", "is true"),
            (3, "c", "is true"),
        ]


@pytest.mark.parametrize(
    ("statement", "question"),
    [
        ("UPDATE run SET acts = '{'", Corpus.all_runs),
        ("UPDATE run SET acts = '[[1]]'", Corpus.all_runs),
        ("""UPDATE run SET acts = '[["1", "set", "a/b", 1]]'""", Corpus.all_runs),
        ("""UPDATE run SET acts = '[[1, "explode", "a/b", 1]]'""", Corpus.all_runs),
        ("UPDATE run SET world = '5'", Corpus.all_runs),
        ("UPDATE run SET violations = '[7]'", Corpus.all_runs),
        ("UPDATE run SET length_ns = 'long'", Corpus.all_runs),
        ("UPDATE finding SET acts = x'00'", Corpus.findings),
        ("UPDATE finding SET reason = '{}'", Corpus.findings),
        ("UPDATE plan SET overrides = '3'", Corpus.origins),
        ("INSERT INTO covered VALUES (x'0011')", Corpus.coverage),
    ],
)
def test_a_row_that_is_damaged_is_refused_in_words(
    tmp_path: Path, statement: str, question: Callable[[Corpus], Any]
) -> None:
    file = tmp_path / "c.sqlite"
    kept(file)
    with closing(Corpus(file)) as corpus:
        corpus.note(Finding(0, "a", (), (), 5, 1, "is true"))
    changed(statement)(file)
    with closing(Corpus(file)) as corpus, pytest.raises(UsageError, match="is damaged: a row of"):
        tuple(question(corpus))


def test_nothing_of_a_damaged_corpus_is_merged(tmp_path: Path) -> None:
    kept(tmp_path / "a.sqlite")
    changed("UPDATE run SET violations = '['")(tmp_path / "a.sqlite")
    with closing(Corpus(tmp_path / "a.sqlite")) as damaged, closing(Corpus(tmp_path / "b.sqlite")) as whole:
        with pytest.raises(UsageError, match=r"a\.sqlite is damaged"):
            whole.merge(damaged)
        assert (list(whole.all_runs()), whole.origins()) == ([], [])


def test_a_place_where_no_file_can_be_is_no_corpus(tmp_path: Path) -> None:
    for file in (tmp_path, tmp_path / "no" / "c.sqlite"):
        with pytest.raises(UsageError, match="cannot be used as a corpus"):
            Corpus(file)


def test_a_corpus_whose_begin_was_cut_off_is_begun_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another process that looks at the file meanwhile sees all tables or none."""
    connect = sqlite3.connect

    def cut(place: Any) -> sqlite3.Connection:
        store = connect(place)
        if place != ":memory:":
            store.set_authorizer(
                lambda action, name, *_: (
                    sqlite3.SQLITE_DENY
                    if (action, name) == (sqlite3.SQLITE_CREATE_TABLE, "covered")
                    else sqlite3.SQLITE_OK
                )
            )
        return store

    file = tmp_path / "corpus.sqlite"
    with monkeypatch.context() as patch:
        patch.setattr(sqlite3, "connect", cut)
        with pytest.raises(UsageError, match="cannot be used any more"):
            Corpus(file)
    Corpus(file).close()
