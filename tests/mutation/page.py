"""The page that tells the result of a run: docs/mutation.md."""

from collections.abc import Sequence

from tests.mutation.places import Mutant


def page(commit: str, seed: str, total_rows: int, mutants: Sequence[Mutant], survivors: Sequence[Mutant]) -> str:
    """Return the page's text; `total_rows` is the number of rows that the sample was taken from."""
    rows = {mutant.row for mutant in mutants}
    lines = [
        "# Mutation of the rows",
        "",
        "This page shows how many deliberate errors the tests of the manuals' rows find. `make mutation` writes it;",
        "don't edit it. The tool changes one place at a time of the code that a row's tests run, and runs the tests of",
        "that row alone. A mutant is killed if they fail.",
        "",
        f"The score is that of a sample, not of all code: {len(mutants)} mutants of {len(rows)} of the {total_rows}",
        f"rows that tests in virtual time show, seed `{seed}`, commit {commit}. Another seed gives another sample and",
        "another score.",
        "",
        "| manual | mutants | killed | score |",
        "|---|---|---|---|",
    ]
    for manual in sorted({row.partition("-")[0] for row in rows}):
        total = sum(mutant.row.startswith(f"{manual}-") for mutant in mutants)
        left = sum(mutant.row.startswith(f"{manual}-") for mutant in survivors)
        lines.append(f"| {manual} | {total} | {total - left} | {(total - left) / total:.0%} |")
    lines += ["", "## Survivors", ""]
    if survivors:
        lines += [
            "A person has to read these: the place may serve another row, or the change may make no difference.",
            "",
        ]
    else:
        lines.append("No mutant of this sample survived.")
    lines += [f"- {one.row}: `{one.file}:{one.line}`, {one.operator.partition('/')[2]}" for one in survivors]
    return "\n".join(lines) + "\n"
