"""Tables of numbers in text, and what the cells of their headers say: names, units."""
