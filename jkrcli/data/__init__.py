"""What others measured or computed, read into SI."""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from ..tables.text_table import MOST_COLUMNS, SEPARATORS, some
    from .columns import NO_UNIT
    from .measured import each, from_columns, read, usable
    from .measured.curve import (
        APPROACH,
        ARBITRARY,
        AS_DEPTH,
        GAPS,
        NOT_SUBTRACTED,
        OVERRULED,
        RETRACT,
        TURNED,
        Curve,
        Pixel,
        Reading,
    )
    from .measured.saturation import saturation
    from .measured.tip_position import SUBTRACTED_TWICE
    from .record import BaseLine, Direction, ForceCurve, examine
    from .zero_points import with_zero_points

__getattr__ = lazily(__name__, __file__)
