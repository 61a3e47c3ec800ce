"""What others measured or computed, read into SI."""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from .columns import NO_UNIT
    from .measured import (
        APPROACH,
        AS_DEPTH,
        NOT_SUBTRACTED,
        OVERRULED,
        RETRACT,
        SUBTRACTED_TWICE,
        Curve,
        Pixel,
        Reading,
        each,
        from_columns,
        usable,
    )
    from .measured.saturation import saturation
    from .record import BaseLine, Direction, ForceCurve, examine
    from .text_table import SEPARATORS, some
    from .zero_points import with_zero_points

__getattr__ = lazily(__name__, __file__)
