"""Closed forms: one equation, one function, all parameters required."""
