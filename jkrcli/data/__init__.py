"""What others measured or computed, read into SI."""
