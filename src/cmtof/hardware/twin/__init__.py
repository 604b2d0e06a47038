"""The simulated instrument: servers that speak the real protocols before one physical model."""
