"""Adhesion that depends on the speed of the contact's edge: laws, what the device does, and what the edge does then.

G = S'(a) (delta_H - delta)^2/(4 pi a) drives the edge: it recedes where G exceeds w0 and advances where G is below the
work of adhesion of advance; between them it rests (Maugis and Barquins, J. Phys. D 11 (1978) 1989).
"""
