"""From a nonadhesive series to the adhesive curve and what it means."""
