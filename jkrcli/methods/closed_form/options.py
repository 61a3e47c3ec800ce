"""What is known of the method ``closed-form`` before it is imported; it has no options."""

from ..protocol import Descriptor, register

register(
    Descriptor(
        "closed-form",
        "Formulae for the half-space and for one thin layer, where they hold.",
        "jkrcli.methods.closed_form.method:ClosedForm",
        effort=10,
        exact=True,
        kernel=True,
    )
)
