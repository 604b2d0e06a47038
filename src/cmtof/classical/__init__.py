"""Classical unwrapping methods, a method a function: measurement in, `Estimate` out."""
