"""What others measured or computed, read into SI."""

from __future__ import annotations

from ..base.lazy import lazily

TYPE_CHECKING = False
if TYPE_CHECKING:
    from ..tables import MOST_COLUMNS, SEPARATORS, some
    from .curve import (
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
    from .measured import each, from_columns, read, usable
    from .segmentation import SUBTRACTED_TWICE, BaseLine, Direction, ForceCurve, examine, saturation, with_zero_points
    from .tables import NO_UNIT

__getattr__ = lazily(__name__, __file__)
