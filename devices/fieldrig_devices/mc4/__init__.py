"""MC-4: the drive of one axis on the fibre ring (ELAU PacDrive system manual)."""
