"""The simulated instrument: light, optics, electronics and targets, with their settings."""
