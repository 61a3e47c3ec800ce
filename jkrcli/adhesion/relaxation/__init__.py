"""Contact of bodies that relax, without adhesion: E(t) = E r(t), one function for all layers, constant nu.

The pressure is a sum of flat ends. Inside every smaller radius a flat end moves the surface rigidly, on any body, so
that only the last one matters (Ting, J. Appl. Mech. 33 (1966) 845; here for layers, gradings, cylinders, any tip).
"""
