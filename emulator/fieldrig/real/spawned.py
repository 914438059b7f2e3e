"""Entry point of a spawned process of a rig: `python -m fieldrig.real.spawned PIPE MODULE FILE ...`.

Importing is most of the work of such a process before it can run devices, so it reports its steps before the first
import.  `PIPE` is the writing end of the pipe to its supervisor, or empty without one; the arguments after `MODULE` are
those of its `main`.
"""

import importlib
import sys

from fieldrig.real import progress

if __name__ == "__main__":
    if sys.argv[1]:
        progress.report_to(int(sys.argv[1]))
        progress.report_imports()
    importlib.import_module(sys.argv[2]).main(sys.argv[3:])
