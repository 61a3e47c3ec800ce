"""The method ``hybrid``: exact half-space, finite elements for the smooth rest."""
