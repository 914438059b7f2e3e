"""Reports of tests: for people, for CI and for other tools."""
