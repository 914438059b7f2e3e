"""EDS checker: the file that the node is measured by, as `fieldrig eds check` sees it.

Source: CiA 306-1 4.3 to 4.6.  Warnings don't fail the case.
"""

from fieldrig_devices.canopen.eds_check import Finding, Severity, check_eds
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.line import Steps

SHOWN = 5


@case(
    "1.0",
    "EDS checker",
    "The EDS has what CiA 306 asks for: its sections, the mandatory objects, and defaults within limits.",
    "CiA 306-1 4.3 to 4.6; CiA 301 7.5.2",
)
def eds_file(bench: Bench) -> Steps[None]:
    errors = [_text(one) for one in check_eds(bench.eds.path) if one.severity is Severity.ERROR]
    more = f"; and {len(errors) - SHOWN} more" if len(errors) > SHOWN else ""
    bench.check(not errors, "an EDS without errors", "; ".join(errors[:SHOWN]) + more)
    yield from bench.wait(0)


def _text(finding: Finding) -> str:
    return f"line {finding.line}: [{finding.section}] {finding.key} {finding.what}: {finding.remedy}"
