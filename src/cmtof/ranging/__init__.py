"""Instruments that measure a distance, each as forward model, estimator and bound (Sec. 8.2)."""
