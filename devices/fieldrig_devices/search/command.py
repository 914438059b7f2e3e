"""`fieldrig search`: looks for the faults and instants that break a program."""

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from fieldrig.cli.common import AsJson, Overrides, argument, command_group, duration_ns, echo_json, writing
from fieldrig.clock import S
from fieldrig.errors import UsageError
from fieldrig.points.values import counted
from fieldrig.system.exits import Exit
from fieldrig.text.nearest import nearest_file

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fieldrig_devices.search.corpus import Corpus, Finding, Origin
    from fieldrig_devices.search.plan import Plan
    from fieldrig_devices.search.strategy import Shard

SECTION = "Run a rig"
"""The group of the command in the help of `fieldrig`."""


class Searching(TyperGroup):
    """`fieldrig search RIG --property FILE` means `fieldrig search run RIG --property FILE`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        is_file = bool(args) and args[0] not in self.commands and not args[0].startswith("-")
        return super().parse_args(ctx, ["run", *args] if is_file else args)


app = command_group(Searching)
PlanFile = Annotated[Path, argument("PLAN", "The plan: a scenario, and what may happen besides.")]
CorpusFile = Annotated[Path, argument("CORPUS", "The file with the runs and findings of searches.")]
PlanOption = Annotated[
    Path | None, typer.Option("--plan", metavar="PLAN", help="The plan, if it is not where it was.", show_default=False)
]
Numbers = Annotated[list[int] | None, argument("NUMBER...", "The findings, as `show` numbers them; all without one.")]
CORPUS = "search.sqlite"


@app.callback()
def search() -> None:
    """Look for the faults and instants that break a program, in virtual time.

    \b
        fieldrig search run configs/searches/feeder.yaml --budget 10min
        fieldrig search configs/feeder.yaml --property properties.yaml
        fieldrig search show search.sqlite
        fieldrig search compare configs/searches/feeder.yaml search.sqlite
    """


@app.command()
def run(
    plan: Annotated[Path, argument("PLAN", "The plan: a scenario, and what may happen besides; or a rig file.")],
    properties: Annotated[
        Path | None,
        typer.Option(
            "--property", metavar="FILE", help="What has to hold: a plan for the rig file.", show_default=False
        ),
    ] = None,
    overrides: Overrides = None,
    strategies: Annotated[
        str, typer.Option("--strategy", metavar="NAMES", help="The strategies, which take turns.")
    ] = "sweep,archive",
    budget: Annotated[
        str | None,
        typer.Option("--budget", metavar="DURATION", help="The time of this machine; 60s without --cpu."),
    ] = None,
    cpu: Annotated[
        str | None,
        typer.Option(
            "--cpu",
            metavar="DURATION",
            help="The time of processors, of all branches together: the same on a loaded machine.",
            show_default=False,
        ),
    ] = None,
    most: Annotated[int, typer.Option("--most", metavar="N", min=1, help="At most N runs.")] = 1_000_000,
    is_first: Annotated[bool, typer.Option("--first", help="End at the first finding.")] = False,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="The seed of what is left to chance.")] = 1,
    workers: Annotated[int, typer.Option("--jobs", "-j", metavar="N", min=1, help="Run N branches at a time.")] = 2,
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Have the workers of the Dask cluster with this scheduler run them, such as tcp://10.0.0.1:8786.",
            show_default=False,
        ),
    ] = None,
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
    html: Annotated[
        Path | None,
        typer.Option(
            "--html",
            metavar="FOLDER",
            help="Write a report as a page, with the coverage of the programs, and what --findings writes.",
            show_default=False,
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Search. The exit code is 1 if a property can be broken.

    Each way to break one is made as small as possible, and repeats bit for bit.
    """
    from fieldrig.coverage.summary import Coverage
    from fieldrig_devices.search.bench import Bench
    from fieldrig_devices.search.cluster import ClusterCrew
    from fieldrig_devices.search.corpus import Corpus, Origin
    from fieldrig_devices.search.crew import LocalCrew
    from fieldrig_devices.search.memory import identity_of
    from fieldrig_devices.search.rig_files import luggage_of
    from fieldrig_devices.search.search import Limits, Search
    from fieldrig_devices.search.tally import Tally

    origin = Origin(str(properties or plan), "" if properties is None else str(plan), tuple(overrides or ()))
    given, chosen, part = _plan(origin), _chosen(strategies), _shard(shard)
    limits = Limits(_seconds(budget or (None if cpu else "60s")), most, _seconds(cpu), is_first)
    store = Corpus(corpus)
    store.come_from(origin)
    luggage = luggage_of(given) if dask else None
    identity = identity_of(given, Path(origin.file), luggage)
    with Bench(given) as bench, ClusterCrew(dask, luggage) if dask and luggage else LocalCrew(bench, workers) as crew:
        tally, told, is_interrupted = Tally(crew), list[str](), False
        one = Search(given, bench, tally, store, seed, part, identity)

        def tell(line: str) -> None:
            told.append(line)
            typer.echo(line, err=as_json)

        try:
            one.go(chosen, limits, tell, lambda line: typer.echo(line, err=True))
        except KeyboardInterrupt:  # what was found until then is a result
            is_interrupted = True
            tell(f"interrupted after {counted(one.runs, 'run')}")
        store.cover(Coverage(tuple(tally.seen(bench.places))))
    found = store.findings()
    _show(found, as_json=as_json)
    if findings is not None:
        _write_findings(given, store, findings, as_json=as_json)
    if html is not None:
        _write_report(given, store, told, html, as_json=as_json)
    if found:
        raise typer.Exit(Exit.TESTS_FAILED)
    if is_interrupted:
        raise KeyboardInterrupt


@app.command()
def report(
    corpus: CorpusFile,
    folder: Annotated[Path, argument("FOLDER", "The folder for the page and all that belongs to it.")],
    plan: PlanOption = None,
) -> None:
    """Write the report of a corpus as a page, such as of one that `merge` has put together.

    It has what `run --html` writes: findings with pictures, scenarios and a test, strategies, and the coverage.
    """
    store = _opened(corpus)
    _write_report(_plan_of(store, plan), store, [], folder)


@app.command()
def show(corpus: CorpusFile, as_json: AsJson = False) -> None:
    """Show the findings of a corpus."""
    _show(_opened(corpus).findings(), as_json=as_json)


@app.command()
def replay(corpus: CorpusFile, numbers: Numbers = None, plan: PlanOption = None) -> None:
    """Play findings again, and tell what happens. The exit code is 1 if a property still does not hold."""
    from fieldrig_devices.search.comparing import replayed

    store, is_broken = _opened(corpus), False
    for one in replayed(_plan_of(store, plan), _numbered(store, numbers)):
        typer.echo(f"{one.finding.number}. {one.finding.property}: {one.told[0] if one.told else 'holds now'}")
        for line in one.told[1:]:
            typer.echo(f"     {line}")
        typer.echo(f"     each message is {'the same' if one.is_same else 'not the same any more'}")
        is_broken |= bool(one.told)
    if is_broken:
        raise typer.Exit(Exit.TESTS_FAILED)


@app.command()
def minimise(corpus: CorpusFile, numbers: Numbers = None, plan: PlanOption = None) -> None:
    """Make findings small again, such as after a change of the program or of the plan."""
    from fieldrig_devices.search.comparing import minimised

    store = _opened(corpus)
    _show(list(minimised(_plan_of(store, plan), store, _numbered(store, numbers))), as_json=False)


@app.command()
def merge(
    target: Annotated[Path, argument("TARGET", "The corpus that gets everything.")],
    others: Annotated[list[Path], argument("CORPUS...", "The others.")],
) -> None:
    """Add the runs and findings of other corpora to one, such as those of several machines."""
    from fieldrig_devices.search.corpus import Corpus

    opened = [_opened(other) for other in others]  # before the target is made
    whole = Corpus(target)
    for corpus in opened:
        whole.merge(corpus)
    runs, found = sum(1 for _ in whole.all_runs()), len(whole.findings())
    typer.echo(f"{target}: {counted(runs, 'run')}, {counted(found, 'finding')}")


@app.command()
def compare(
    plan: PlanFile,
    corpus: CorpusFile,
    workers: Annotated[int, typer.Option("--jobs", "-j", metavar="N", min=1, help="Run N branches at a time.")] = 2,
    as_json: AsJson = False,
) -> None:
    """Play the runs of a corpus again after the program was changed, and list what holds now or no longer does.

    The exit code is 1 if a run has become worse.
    """
    from fieldrig_devices.search.comparing import compared
    from fieldrig_devices.search.plan import load_plan

    changes = compared(load_plan(plan), _opened(corpus), workers)
    worse = [one for one in changes if one.is_worse]
    if as_json:
        echo_json([one._asdict() for one in changes])
    else:
        for one in changes:
            typer.echo(str(one))
        typer.echo(f"{len(worse)} worse, {len(changes) - len(worse)} better")
    if worse:
        raise typer.Exit(Exit.TESTS_FAILED)


def _write_findings(plan: "Plan", corpus: "Corpus", folder: Path, *, as_json: bool = False) -> dict[int, Path]:
    """Write scenarios, pictures and a test, and return the scenarios by the numbers of the findings."""
    from fieldrig_devices.search.findings import write

    found = corpus.findings()
    with writing(folder):
        files = write(plan.scenario, found, folder)
    for file in files:
        typer.echo(f"fieldrig scenario run {file}", err=as_json)
    return {one.number: file for one, file in zip(found, files, strict=True)}


def _write_report(
    plan: "Plan", corpus: "Corpus", told: "Sequence[str]", folder: Path, *, as_json: bool = False
) -> None:
    from fieldrig_devices.search.html_report import write_report

    files = _write_findings(plan, corpus, folder, as_json=as_json)
    title = f"Search of {plan.scenario.rig.stem}"
    with writing(folder):
        page = write_report(title, corpus, files, told, corpus.coverage(), folder)
    typer.echo(f"{page}", err=as_json)


def _seconds(duration: str | None) -> float:
    return math.inf if duration is None else duration_ns(duration) / S


def _opened(file: Path) -> "Corpus":
    from fieldrig_devices.search.corpus import Corpus

    if not file.is_file():
        raise UsageError(f"there is no {file}", nearest_file(file) or "expected the corpus of a search")
    return Corpus(file)


def _plan(origin: "Origin") -> "Plan":
    from fieldrig_devices.search.plan import load_plan, plan_for

    file = Path(origin.file)
    return plan_for(Path(origin.rig), file, origin.overrides) if origin.rig else load_plan(file, origin.overrides)


def _plan_of(corpus: "Corpus", file: Path | None) -> "Plan":
    """Return the plan of a corpus.  UsageError if it has several, and none is named."""
    origins = corpus.origins()
    if file is not None:
        from fieldrig_devices.search.corpus import Origin

        return _plan(origins[0]._replace(file=str(file)) if len(origins) == 1 else Origin(str(file), "", ()))
    if len(origins) != 1:
        raise UsageError(f"the corpus comes from {len(origins)} plans", "name one of them with --plan")
    return _plan(origins[0])


def _numbered(corpus: "Corpus", numbers: list[int] | None) -> "list[Finding]":
    """Return the findings with these numbers, all without any.  UsageError for one that there is not."""
    found = {one.number: one for one in corpus.findings()}
    for number in numbers or ():
        if number not in found:
            raise UsageError(f"there is no finding {number}", f"there are: {', '.join(map(str, found)) or 'none'}")
    return [found[number] for number in numbers or found]


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
        for override in one.world:
            typer.echo(f"     with {override}")
        for act in one.acts:
            typer.echo(f"     at {act.at_ns / 1e6:g} ms: {act}")
    typer.echo(counted(len(found), "finding") if found else "nothing was found")
