"""What is pressed on what: indenters, materials, layers, loading; SI, no mesh, no work of adhesion."""
