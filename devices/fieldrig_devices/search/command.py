"""`fieldrig search`: looks for the faults and instants that break a program."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import AsJson, argument, command_group, duration_ns, echo_json, writing
from fieldrig.clock import S
from fieldrig.errors import UsageError
from fieldrig.system.exits import Exit

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fieldrig_devices.search.corpus import Corpus, Finding
    from fieldrig_devices.search.strategy import Shard

SECTION = "Run a rig"
"""The group of the command in the help of `fieldrig`."""
app = command_group()
PlanFile = Annotated[Path, argument("PLAN", "The plan: a scenario, and what may happen besides.")]
CorpusFile = Annotated[Path, argument("CORPUS", "The file with the runs and findings of searches.")]
CORPUS = "search.sqlite"


@app.callback()
def search() -> None:
    """Look for the faults and instants that break a program, in virtual time.

    \b
        fieldrig search run configs/searches/feeder.yaml --budget 10min
        fieldrig search show search.sqlite
        fieldrig search compare configs/searches/feeder.yaml search.sqlite
    """


@app.command()
def run(
    plan: PlanFile,
    strategies: Annotated[
        str, typer.Option("--strategy", metavar="NAMES", help="The strategies, one after the other.")
    ] = "sweep,archive",
    budget: Annotated[str, typer.Option("--budget", metavar="DURATION", help="The time of this machine.")] = "60s",
    most: Annotated[int, typer.Option("--most", metavar="N", min=1, help="At most N runs.")] = 1_000_000,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="The seed of what is left to chance.")] = 1,
    workers: Annotated[int, typer.Option("--jobs", "-j", metavar="N", min=1, help="Run N branches at a time.")] = 2,
    shard: Annotated[
        str, typer.Option("--shard", metavar="I/N", help="Do only this part, as one of N machines; `merge` joins them.")
    ] = "1/1",
    corpus: Annotated[Path, typer.Option("--corpus", metavar="FILE", help="The file for runs and findings.")] = Path(
        CORPUS
    ),
    findings: Annotated[
        Path | None,
        typer.Option("--findings", metavar="FOLDER", help="Write scenarios, pictures and a test.", show_default=False),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Search. The exit code is 1 if a property can be broken.

    Each way to break one is made as small as possible, and repeats bit for bit.
    """
    from fieldrig_devices.search.corpus import Corpus
    from fieldrig_devices.search.crew import Bench, LocalCrew
    from fieldrig_devices.search.findings import write
    from fieldrig_devices.search.plan import load_plan
    from fieldrig_devices.search.search import Limits, Search

    given, chosen, part = load_plan(plan), _chosen(strategies), _shard(shard)
    store = Corpus(corpus)
    with Bench(given) as bench, LocalCrew(bench, workers) as crew:
        one = Search(given, bench, crew, store, seed, part)
        limits = Limits(duration_ns(budget) / S, most)
        one.go(chosen, limits, lambda line: typer.echo(line, err=as_json))
    found = store.findings()
    _show(found, as_json=as_json)
    if findings is not None:
        with writing(findings):
            for file in write(given.scenario, found, findings):
                typer.echo(f"fieldrig scenario run {file}", err=as_json)
    if found:
        raise typer.Exit(Exit.TESTS_FAILED)


@app.command()
def show(corpus: CorpusFile, as_json: AsJson = False) -> None:
    """Show the findings of a corpus."""
    _show(_opened(corpus).findings(), as_json=as_json)


@app.command()
def merge(
    target: Annotated[Path, argument("TARGET", "The corpus that gets everything.")],
    others: Annotated[list[Path], argument("CORPUS...", "The others.")],
) -> None:
    """Add the runs and findings of other corpora to one, such as those of several machines."""
    from fieldrig_devices.search.corpus import Corpus

    whole = Corpus(target)
    for other in others:
        whole.merge(_opened(other))
    typer.echo(f"{target}: {sum(1 for _ in whole.runs())} runs, {len(whole.findings())} findings")


@app.command()
def compare(plan: PlanFile, corpus: CorpusFile, as_json: AsJson = False) -> None:
    """Play the runs of a corpus again after the program was changed, and list what holds now or no longer does.

    The exit code is 1 if a run has become worse.
    """
    from fieldrig_devices.search.comparing import compared
    from fieldrig_devices.search.plan import load_plan

    changes = compared(load_plan(plan), _opened(corpus))
    worse = [one for one in changes if one.is_worse]
    if as_json:
        echo_json([one._asdict() for one in changes])
    else:
        for one in changes:
            typer.echo(str(one))
        typer.echo(f"{len(worse)} worse, {len(changes) - len(worse)} better")
    if worse:
        raise typer.Exit(Exit.TESTS_FAILED)


def _opened(file: Path) -> "Corpus":
    from fieldrig_devices.search.corpus import Corpus

    if not file.is_file():
        raise UsageError(f"there is no {file}", "expected the corpus of a search")
    return Corpus(file)


def _chosen(strategies: str) -> "Sequence[str]":
    from fieldrig_devices.search.strategies import STRATEGIES

    names = [name.strip() for name in strategies.split(",")]
    for name in names:
        if name not in STRATEGIES:
            raise typer.BadParameter(f"expected {', '.join(STRATEGIES)}, got {name!r}", param_hint="--strategy")
    return names


def _shard(text: str) -> "Shard":
    from fieldrig_devices.search.strategy import Shard

    found = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text)
    number, of = (int(found[1]), int(found[2])) if found else (0, 0)
    if not 1 <= number <= of:
        raise typer.BadParameter(f"expected a part such as 2/4, got {text!r}", param_hint="--shard")
    return Shard(number - 1, of)


def _show(found: "Sequence[Finding]", *, as_json: bool) -> None:
    if as_json:
        echo_json([one._asdict() for one in found])
        return
    for one in found:
        typer.echo(f"{one.number}. {one.property}: at {one.at_ns / 1e6:g} ms {one.what}")
        for act in one.acts:
            typer.echo(f"     at {act.at_ns / 1e6:g} ms: {act}")
    typer.echo(f"{len(found)} findings" if found else "nothing was found")
