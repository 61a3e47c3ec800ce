"""What is known of the method ``closed-form`` before it is imported; it has no options."""

from ..protocol import Descriptor, register

SENTENCE = "Formulae for the half-space and for one thin layer, where they hold."
SOLVER = "jkrcli.methods.closed_form.method:ClosedForm"
register(Descriptor("closed-form", SENTENCE, SOLVER, 10, exact=True, kernel=True))
