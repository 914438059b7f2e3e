"""Entry point of a spawned process of a rig: `python -m fieldrig.spawned PIPE FILE --process NAME ...`.

Importing is most of the work of such a process before it can run devices, so it reports its steps before the first
import.  `PIPE` is the writing end of the pipe to its supervisor, or empty without one; the other arguments are those of
`fieldrig.host`.
"""

import sys

from fieldrig import progress

if __name__ == "__main__":
    if sys.argv[1]:
        progress.report_to(int(sys.argv[1]))
        progress.report_imports()
    from fieldrig.host import main

    main(sys.argv[2:])
