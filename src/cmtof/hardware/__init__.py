"""The instrument: drivers, rig settings, scans, calibration, and reduction to measurements."""
