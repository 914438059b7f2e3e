"""Entry point of a spawned process of a rig: `python -m fieldrig.real.spawned PIPE FILE --process NAME ...`.

Importing is most of the work of such a process before it can run devices, so it reports its steps before the first
import.  `PIPE` is the writing end of the pipe to its supervisor, or empty without one; the other arguments are those of
`fieldrig.real.host`.
"""

import sys

from fieldrig.real import progress

if __name__ == "__main__":
    if sys.argv[1]:
        progress.report_to(int(sys.argv[1]))
        progress.report_imports()
    from fieldrig.real.host import main

    main(sys.argv[2:])
