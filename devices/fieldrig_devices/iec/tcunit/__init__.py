"""TcUnit: suites of unit tests in Structured Text, run natively in virtual time."""
