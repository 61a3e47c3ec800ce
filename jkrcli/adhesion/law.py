"""The law of attraction of finite range, and the request for one."""

from __future__ import annotations

from dataclasses import dataclass

from ..base import InputError, positive
from ..series import Record


@dataclass(frozen=True)
class Range:
    """The law of attraction of finite range: a constant tension ``stress`` [Pa] up to the separation ``length`` [m]
    (Dugdale, as Maugis took it)."""

    stress: float
    length: float

    def __post_init__(self) -> None:
        positive("Pa", stress=self.stress)
        positive("m", range=self.length)

    @classmethod
    def of(cls, w: float, *, stress: float | None = None, length: float | None = None) -> Range:
        """The law of the work of adhesion ``w`` [J/m^2] with one of ``stress`` [Pa] and ``length`` [m]."""
        if (stress is None) == (length is None):
            raise InputError("adhesion of finite range: give either stress or range")
        positive("J/m^2", w=w)
        if stress is not None:
            positive("Pa", stress=stress)
            return cls(stress, w / stress)
        assert length is not None
        positive("m", range=length)
        return cls(w / length, length)

    @property
    def w(self) -> float:
        """Work of adhesion [J/m^2]."""
        return self.stress * self.length


@dataclass(frozen=True)
class RangeRequest:
    """The requested tension ``stress`` [Pa] or range ``length`` [m], for any work of adhesion; neither: JKR."""

    stress: float | None = None
    length: float | None = None

    @classmethod
    def of(cls, record: Record, stress: float | None = None, length: float | None = None) -> RangeRequest:
        """The ``stress`` [Pa] or the ``length`` [m] if there is one, else those of the case in ``record``; InputError
        where there are both."""
        if stress is not None and length is not None:
            raise InputError("give either --stress or --range, got both")
        if stress is None and length is None:
            return cls(record.stress, record.length)
        return cls(stress, length)

    def __bool__(self) -> bool:
        """Whether adhesion has a range."""
        return self.stress is not None or self.length is not None

    def law(self, w: float) -> Range:
        """The law for the work of adhesion ``w`` [J/m^2]."""
        return Range.of(w, stress=self.stress, length=self.length)

    @property
    def suffix(self) -> str:
        """What distinguishes names of files: ``-stress1e+08``, ``-range3e-10``."""
        if self.stress is not None:
            return f"-stress{self.stress:g}"
        return "" if self.length is None else f"-range{self.length:g}"
