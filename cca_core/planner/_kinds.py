"""Types of the arithmetic that is written for the compiled kernel."""

from typing import Annotated, Protocol

Real = float
Int = int
Flag = bool


class Reals(Protocol):
    """Lent row of float64."""

    def __getitem__(self, at: int, /) -> float: ...
    def __setitem__(self, at: int, value: float, /) -> None: ...


class Ints(Protocol):
    """Lent row of int32."""

    def __getitem__(self, at: int, /) -> int: ...
    def __setitem__(self, at: int, value: int, /) -> None: ...


class Grid(Protocol):
    """Lent rows of float64, one behind the other."""

    def __getitem__(self, at: tuple[int, int], /) -> float: ...
    def __setitem__(self, at: tuple[int, int], value: float, /) -> None: ...


OnRoute = Annotated[Reals, "n"]
OnPaths = Annotated[Grid, "paths", "n"]
Overtakes = Annotated[Grid, "paths", "m"]
Times = Annotated[Reals, "steps"]
Motions = Annotated[Grid, "m", "steps"]
PerVehicle = Annotated[Reals, "m"]
VehicleMarks = Annotated[Ints, "m"]
Runs = Annotated[Grid, "rows", "steps"]
RunMarks = Annotated[Ints, "rows"]
Terms = Annotated[Grid, "rows", 12]
Stops = Annotated[Reals, 8]
