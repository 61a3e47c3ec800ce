"""Numbers and pictures of results."""
