"""Studies of the methods themselves, run by make: speed against accuracy, failures, noise, tuned numbers, figures."""
