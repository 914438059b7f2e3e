"""The page that tells the result of a run: docs/mutation.md."""

from collections.abc import Sequence

from tests.mutation.places import Mutant, Verdict

Judged = Sequence[tuple[Mutant, Verdict]]


def page(commit: str, seed: str, total_rows: int, judged: Judged) -> str:
    """Return the page's text; `total_rows` is the number of rows that the sample was taken from."""
    rows = {mutant.row for mutant, _ in judged}
    lines = [
        "# Mutation of the rows",
        "",
        "This page shows how many deliberate errors the tests of the manuals' rows find. `make mutation` writes it;",
        "don't edit it. The tool changes one place at a time of the code that a row's tests run, and runs the tests of",
        "that row alone. A mutant is killed if they fail. If they pass, the tests of all other rows that run the place",
        "are run too: a mutant that one of them kills is no survivor, but the row's own tests don't show the place.",
        "",
        f"The score is that of a sample, not of all code: {len(judged)} mutants of {len(rows)} of the {total_rows}",
        f"rows that tests in virtual time show, seed `{seed}`, commit {commit}. Another seed gives another sample and",
        "another score.",
        "",
        "| manual | mutants | killed by the row's tests | by another row's | survived | score |",
        "|---|---|---|---|---|---|",
    ]
    for manual in sorted({row.partition("-")[0] for row in rows}):
        verdicts = [verdict for mutant, verdict in judged if mutant.row.startswith(f"{manual}-")]
        counts = [verdicts.count(verdict) for verdict in Verdict]
        score = 1 - verdicts.count(Verdict.SURVIVED) / len(verdicts)
        lines.append(f"| {manual} | {len(verdicts)} | {' | '.join(map(str, counts))} | {score:.0%} |")
    lines += _listed("Survivors", judged, Verdict.SURVIVED)
    lines += _listed("Killed by another row's tests", judged, Verdict.ELSEWHERE)
    return "\n".join(lines) + "\n"


def _listed(title: str, judged: Judged, verdict: Verdict) -> list[str]:
    places = [
        f"- {entry.row}: `{entry.file}:{entry.line}`, {entry.operator.partition('/')[2]}"
        for entry, judgement in judged
        if judgement is verdict
    ]
    if not places:
        return ["", f"## {title}", "", "No mutant of this sample."]
    reading = "A person has to read these: the place may serve another row, or the change may make no difference."
    return ["", f"## {title}", "", reading, "", *places]
