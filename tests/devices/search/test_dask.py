"""A search on a Dask cluster finds what a pool finds, also when a worker is lost, and says what is wrong."""

import subprocess
import sys
from pathlib import Path

import pytest
from dask_cluster import Cluster, cluster
from running_rig import until
from st_tests import LAMP_RIG, STUCK_LAMP

from fieldrig.testing import free_port
from fieldrig_devices.search.corpus import Corpus

pytestmark = [pytest.mark.system, pytest.mark.timeout(600)]
pytest.importorskip("distributed", reason="pip install distributed")

PLAN = """\
rig: rigs/rig.yaml
after: 500ms
for: 1s
steps:
- {at: 100ms, set: {wires/switch.on: true}}
- {at: 600ms, set: {wires/switch.on: false}}
properties:
  the lamp goes out: {never: wires/lamp.on and not wires/switch.on, longer: 50ms}
vary:
- {press: {wires/switch.on: true}, hold: 50ms}
states: [terminal/presses, wires/lamp.on]
"""
RUNS = 200


def searched(folder: Path, corpus: str, *options: str) -> "subprocess.Popen[str]":
    strategies = ["--strategy", "archive,swarm", "--most", str(RUNS), "--budget", "10min", "--corpus", corpus]
    command = [sys.executable, "-m", "fieldrig", "search", "run", "plan.yaml", *strategies, *options]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def outcome(search: "subprocess.Popen[str]") -> tuple[int, str]:
    """Return exit code and output at the end of a search."""
    said, _ = search.communicate(timeout=500)
    return search.returncode, said


def hash_of(file: Path) -> str:
    corpus = Corpus(file)
    try:
        assert corpus.findings()
        return corpus.hash()
    finally:
        corpus.close()


def runs_in(file: Path) -> int:
    if not file.exists():
        return 0
    corpus = Corpus(file)
    try:
        return sum(1 for _ in corpus.runs())
    finally:
        corpus.close()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "rigs").mkdir()
    (tmp_path / "rigs/rig.yaml").write_text(LAMP_RIG)
    (tmp_path / "rigs/lamp.st").write_text(STUCK_LAMP)
    (tmp_path / "plan.yaml").write_text(PLAN)
    return tmp_path


def lose_one(workers: Cluster, corpus: Path) -> None:
    """Kill a worker in the middle of the search."""
    until(lambda: runs_in(corpus) > RUNS // 4)
    workers.kill_worker()
    assert runs_in(corpus) < RUNS


def test_pool_cluster_and_cluster_with_a_lost_worker_find_the_same(folder: Path, tmp_path: Path) -> None:
    assert outcome(searched(folder, "pool.sqlite"))[0] == 1
    with cluster(2, tmp_path) as workers:
        code, said = outcome(searched(folder, "dask.sqlite", "--dask", workers.address))
        assert code == 1, said
        search = searched(folder, "lost.sqlite", "--dask", workers.address)
        lose_one(workers, folder / "lost.sqlite")
        code, said = outcome(search)
        assert code == 1, said
    assert hash_of(folder / "pool.sqlite") == hash_of(folder / "dask.sqlite") == hash_of(folder / "lost.sqlite")


def test_a_worker_whose_nanny_starts_it_again_goes_on(folder: Path, tmp_path: Path) -> None:
    assert outcome(searched(folder, "pool.sqlite"))[0] == 1
    with cluster(1, tmp_path, have_nannies=True) as workers:  # no other worker could go on
        search = searched(folder, "lost.sqlite", "--dask", workers.address)
        lose_one(workers, folder / "lost.sqlite")
        code, said = outcome(search)
        assert code == 1, said
    assert hash_of(folder / "pool.sqlite") == hash_of(folder / "lost.sqlite")


def test_a_search_without_its_cluster_says_so(folder: Path) -> None:
    code, said = outcome(searched(folder, "none.sqlite", "--dask", f"tcp://127.0.0.1:{free_port()}"))
    assert code == 3
    assert "no scheduler of Dask answers" in said
