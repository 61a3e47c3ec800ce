"""Laws of adhesion over the speed of the contact's edge, from measured records: w0, v0, n and what goes with them."""
