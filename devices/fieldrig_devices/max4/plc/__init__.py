"""The PLC of a MAx-4: IEC programs, their tasks and retained data, and what they see of the controller."""
