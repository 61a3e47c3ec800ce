"""The integral-equation solver of axisymmetric contact: exact for layered bodies, reusable for any smooth kernel."""
