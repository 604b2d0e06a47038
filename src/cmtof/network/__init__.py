"""The learned unwrapping: inputs, networks, training and weights."""
