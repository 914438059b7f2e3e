"""Reports of coverage: for people, as LCOV, as Cobertura, and as a page."""
