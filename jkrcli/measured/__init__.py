"""From measured curves to properties: E, w and zero points by fits, w point by point."""
