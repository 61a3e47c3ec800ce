"""What the same bodies would do otherwise: solved again, without slip, with a range, as a half-space."""
