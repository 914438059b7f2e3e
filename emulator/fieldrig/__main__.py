"""`python -m fieldrig` is `fieldrig`."""

from fieldrig.cli import main

main()
