"""Tests of programs: what a test is, what finds and runs it, and what is reported of it."""
