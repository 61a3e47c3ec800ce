"""Methods behind one interface: each is a frozen dataclass that is called with a problem and returns a solution.

A method makes itself known by a ``Descriptor``, from which the names, the order of "auto" and the tables of a case file
follow; its solver is imported when it is used. ``protocol.py`` registers the two methods of the core and those of
wings, and is light; a method of one's own may register itself in any module that has been imported.
"""

from . import protocol as _protocol  # registers all methods
