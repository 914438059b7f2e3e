"""Cases and outcomes as JSON, for editors and scripts."""

from typing import Any

from fieldrig_devices.iec.testing.case import Case, Failure, Outcome


def case_json(case: Case) -> dict[str, Any]:
    return {"id": str(case), "name": case.name, "suite": case.suite, "file": str(case.file), "line": case.line}


def outcome_json(outcome: Outcome) -> dict[str, Any]:
    return {
        **case_json(outcome.case),
        "verdict": str(outcome.verdict),
        "reason": outcome.reason,
        "asserts": outcome.asserts,
        "duration_ns": outcome.duration_ns,
        "wall_s": round(outcome.wall_s, 6),
        "output": list(outcome.output),
        "failures": [_failure_json(failure) for failure in outcome.failures],
    }


def _failure_json(failure: Failure) -> dict[str, Any]:
    return {**failure._asdict(), "file": str(failure.file), "diagram": list(failure.diagram)}
