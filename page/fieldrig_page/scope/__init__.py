"""The scope: samples of any signals of a rig, triggers, captures, saved set-ups and exports."""
