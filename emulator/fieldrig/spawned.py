"""Where a spawned process of a rig begins: `python -m fieldrig.spawned PIPE FILE --process NAME ...`.

Most of what such a process does before it can work is importing, so it tells its steps before it imports anything.
`PIPE` is the writing end of the pipe to its supervisor, empty where there is none; the other arguments are those of
`fieldrig.host`.
"""

import sys

from fieldrig import progress

if __name__ == "__main__":
    if sys.argv[1]:
        progress.report_to(int(sys.argv[1]))
        progress.tell_imports()
    from fieldrig.host import main

    main(sys.argv[2:])
