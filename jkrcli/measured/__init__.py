"""From measured curves to properties: E, w and contact points by fits, w point by point."""
