"""EDS checker: checks the file by which the node is judged, as `fieldrig eds check` does.

Source: CiA 306-1 4.3 to 4.6.  As in the log of CiA's tool, 'warning' is a separate verdict.
"""

from fieldrig_devices.canopen.eds.check import Finding, Severity, check_eds
from fieldrig_devices.conformance.bench import Bench
from fieldrig_devices.conformance.case import case
from fieldrig_devices.conformance.line import Steps

SHOWN = 5


@case(
    "1.0",
    "EDS checker",
    "The EDS complies with CiA 306: it has the sections, the mandatory objects, and defaults within limits.",
    "CiA 306-1 4.3 to 4.6; CiA 301 7.5.2",
)
def eds_file(bench: Bench) -> Steps[None]:
    found = check_eds(bench.eds.path)
    errors = [_text(finding) for finding in found if finding.severity is not Severity.WARNING]
    bench.check(not errors, "an EDS without errors", _shown(errors))
    if found:
        bench.warn(_shown([_text(finding) for finding in found]))
    yield from bench.wait(0)


def _shown(texts: list[str]) -> str:
    return "; ".join(texts[:SHOWN]) + (f"; and {len(texts) - SHOWN} more" if len(texts) > SHOWN else "")


def _text(finding: Finding) -> str:
    return f"line {finding.line}: [{finding.section}] {finding.key} {finding.what}: {finding.remedy}"
