"""The words among which readings and fits let one choose, and what holds values by name."""

from collections.abc import Mapping
from typing import Literal, TypeAlias

BranchName: TypeAlias = Literal["all", "compressive"]
SegmentName: TypeAlias = Literal["approach", "retract", "both"]
Loss: TypeAlias = Literal["linear", "soft_l1", "huber", "cauchy"]
ContactName: TypeAlias = Literal["auto", "fitted", "as-is", "estimate"]
ConfidenceName: TypeAlias = Literal["covariance", "profile", "bootstrap"]
BaseLineName: TypeAlias = Literal["straight", "sine"]
ModelName: TypeAlias = Literal["jkr", "auto"]
Use: TypeAlias = Literal["a,P", "a,delta", "delta,P"]  # columns from which w follows
Values: TypeAlias = Mapping[str, float]  # of parameters, unknowns or columns, by name
