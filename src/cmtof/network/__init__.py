"""The learned unwrapping: what goes in, and the networks that it goes into."""
