"""One self-contained page to look at the adhesive curve of a series under any w, modulus, device and zero point."""

from .page import Explored, page
from .payload import payload, start_work

__all__ = ["Explored", "page", "payload", "start_work"]
