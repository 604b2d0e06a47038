"""Classical unwrapping methods: each is a function from a measurement to an `Estimate`."""
