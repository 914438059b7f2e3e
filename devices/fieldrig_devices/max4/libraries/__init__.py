"""Motion libraries of the MAx-4: motion laws, profiles, cams, positioning (PacDrive manual 3360-3414)."""
