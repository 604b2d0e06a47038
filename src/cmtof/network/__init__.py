"""Unwrapping by networks: inputs, layers, training, weights and inference."""
