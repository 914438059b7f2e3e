"""The calls of users: two logs compared, and a log played back to a rig."""

from collections.abc import Sequence
from pathlib import Path

from fieldrig.config.rig_file import RigConfig, load
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace_files import read
from fieldrig_devices.replay.comparison import HORIZON_NS, TOLERANCE_NS, compare_logs
from fieldrig_devices.replay.diff_result import DiffResult
from fieldrig_devices.replay.leave_out import leaving_out
from fieldrig_devices.replay.log_names import LogNames


def diff(
    left: str | Path,
    right: str | Path,
    *,
    rig: str | Path | RigConfig | None = None,
    tolerance_ns: int = TOLERANCE_NS,
    window_ns: int = HORIZON_NS,
    offset_ns: int | None = None,
    leave_out: Sequence[str] = (),
    begin_ns: int | None = None,
    duration_ns: int | None = None,
    oddities: tuple[Oddities, Oddities] | None = None,
) -> DiffResult:
    """Compare two logs in files of any format.

    Jitter up to `tolerance_ns` is no difference; messages further apart than `window_ns` are different ones.
    `offset_ns` is how much later the right log is, and None finds it.  `leave_out` has patterns as for `fieldrig diff`.
    With a rig, values have names.  `begin_ns` and `duration_ns` choose a part of the time of both, as for `read_trace`,
    and what is odd in the files goes to `oddities`.  UsageError for a file that is no log, ConfigError for mistakes
    in a rig file.
    """
    odd = oddities or (Oddities(), Oddities())
    config = load(rig) if isinstance(rig, str | Path) else rig
    return compare_logs(
        lambda: read(Path(left), begin_ns, duration_ns, odd[0]),
        lambda: read(Path(right), begin_ns, duration_ns, odd[1]),
        tolerance_ns=tolerance_ns,
        horizon_ns=window_ns,
        offset=offset_ns,
        leave_out=leaving_out(leave_out),
        names=(LogNames(config), LogNames(config)),
    )
