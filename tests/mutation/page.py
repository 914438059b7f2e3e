"""The page with the result of a run: docs/developers/mutation.md."""

from collections.abc import Sequence
from textwrap import fill

from tests.mutation.places import Mutant, Verdict

Judged = Sequence[tuple[Mutant, Verdict]]

WIDTH = 119
NONE = "The sample has no such mutant."
FINDS = (
    "This page tells you how many deliberate errors in the code the tests of the manuals' rows find, and lists those"
    " that they miss. `make mutation` writes it; do not edit it."
)
HOW = (
    "The tool takes one row of a manual at a time, changes one place in the code that the row's tests run, and runs the"
    " tests of that row. The changed code is a mutant, and it is killed if a test fails. If all tests of the row pass,"
    " the tool runs the tests of all other rows that run the same place. A mutant that one of them kills does not count"
    " as a survivor, but it shows that the row's own tests do not check the place."
)
SAMPLE = (
    "The score is that of a sample: {mutants} mutants of {rows} of the {total_rows} rows that tests in virtual time"
    " show, with seed `{seed}`, at commit {commit}. Another seed selects another sample and gives another score."
)
COUNTS = "The table counts the mutants of each manual. The score is the share that the tests of any row kill."
SURVIVORS = (
    "No test of any row fails on these mutants. Each entry names the row, the place and the mutation operator. A"
    " person has to judge each of them: a test may be missing, or the change may make no difference."
)
KILLED_ELSEWHERE = (
    "Only tests of other rows fail on these mutants. A person has to judge each of them: the row's own tests may be too"
    " weak, or the place may serve another row alone."
)


def page(commit: str, seed: str, total_rows: int, judged: Judged) -> str:
    """Return the text of the page; `total_rows` is the number of rows from which the sample was taken."""
    rows = {mutant.row for mutant, _ in judged}
    sample = SAMPLE.format(mutants=len(judged), rows=len(rows), total_rows=total_rows, seed=seed, commit=commit)
    lines = [
        "# Mutation of the rows",
        *(line for text in (FINDS, HOW, sample, COUNTS) for line in ("", fill(text, WIDTH))),
        "",
        "| manual | mutants | killed by the row's tests | killed by another row's tests | survived | score |",
        "|---|---|---|---|---|---|",
    ]
    for manual in sorted({row.partition("-")[0] for row in rows}):
        verdicts = [verdict for mutant, verdict in judged if mutant.row.startswith(f"{manual}-")]
        counts = [verdicts.count(verdict) for verdict in Verdict]
        score = 1 - verdicts.count(Verdict.SURVIVED) / len(verdicts)
        lines.append(f"| {manual} | {len(verdicts)} | {' | '.join(map(str, counts))} | {score:.0%} |")
    lines += _listed("Survivors", SURVIVORS, judged, Verdict.SURVIVED)
    lines += _listed("Killed by another row's tests", KILLED_ELSEWHERE, judged, Verdict.ELSEWHERE)
    return "\n".join(lines) + "\n"


def _listed(title: str, about: str, judged: Judged, verdict: Verdict) -> list[str]:
    places = [
        f"- {mutant.row}: `{mutant.file}:{mutant.line}`, {mutant.operator.partition('/')[2]}"
        for mutant, judgement in judged
        if judgement is verdict
    ]
    return ["", f"## {title}", "", *([fill(about, WIDTH), "", *places] if places else [NONE])]
