"""A plant FMU as plant of the closed loop, such as one of CarSim (extra ``fmi``)."""

import shutil
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Any

from cca_core._optional import require_extra
from cca_core.errors import InputError
from cca_core.vehicle import VehicleState

_INPUTS = {"delta_command": "delta_command", "a_x_command": "a_x_command"}
_OUTPUTS = {name: name for name in ("x", "y", "psi", "v_x", "v_y", "r", "delta", "a_x", "a_y")}


class FmuPlant:
    """Co-simulation FMU of a vehicle, of FMI 2.0 or 3.0.

    Parameters
    ----------
    file : str or pathlib.Path
        The FMU, with a library for this machine.
    inputs : mapping of str to str, optional
        Names of its variables for ``"delta_command"`` [rad] and ``"a_x_command"`` [m/s^2]; the default is
        these names.
    outputs : mapping of str to str, optional
        Names of its variables for the motion: ``"x"``, ``"y"``, ``"psi"``, ``"v_x"``, ``"v_y"``, ``"r"``,
        ``"delta"``, ``"a_x"``, ``"a_y"``, in SI units and ISO 8855 axes.
    start : mapping of str to float, optional
        Start values of further variables by their own names.

    Attributes
    ----------
    a_y : float
        Lateral acceleration of the center of gravity now [m/s^2], left positive.

    Raises
    ------
    InputError
        If the file is no such FMU or a variable is missing.
    MissingExtraError
        If fmpy is not installed.
    """

    def __init__(
        self,
        file: str | FilePath,
        *,
        inputs: Mapping[str, str] | None = None,
        outputs: Mapping[str, str] | None = None,
        start: Mapping[str, float] | None = None,
    ) -> None:
        fmpy = require_extra("fmpy", "fmi")
        try:
            description = fmpy.read_model_description(str(file))
            self._folder = fmpy.extract(str(file))
        except Exception as error:  # fmpy has errors of its own
            raise InputError(f"file must be an FMU, was {str(file)!r}: {error}") from None
        references = {v.name: v.valueReference for v in description.modelVariables}
        self._inputs = _references("inputs", _INPUTS | dict(inputs or {}), references)
        self._outputs = _references("outputs", _OUTPUTS | dict(outputs or {}), references)
        self._is_fmi3 = description.fmiVersion.startswith("3")
        self._fmu, self._t = self._opened(description), 0.0
        for name, value in (start or {}).items():
            self._set(_references("start", {name: name}, references), [value])
        self._read()

    def _opened(self, description: Any) -> Any:
        """Return an FMU that is ready for the first step."""
        module = require_extra("fmpy.fmi3" if self._is_fmi3 else "fmpy.fmi2", "fmi")
        slave = module.FMU3Slave if self._is_fmi3 else module.FMU2Slave
        try:
            fmu = slave(
                guid=description.guid, unzipDirectory=self._folder,
                modelIdentifier=description.coSimulation.modelIdentifier, instanceName="plant",
            )  # fmt: skip
            fmu.instantiate()
            if not self._is_fmi3:
                fmu.setupExperiment(startTime=0.0)
            fmu.enterInitializationMode()
            fmu.exitInitializationMode()
        except Exception as error:
            raise InputError(f"file must be an FMU that runs on this machine: {error}") from None
        return fmu

    @property
    def state(self) -> VehicleState:
        """Motion of the center of gravity now."""
        return self._state

    def step(self, delta: float, a_x: float, dt: float) -> None:
        """Advance by a time step.

        Parameters
        ----------
        delta : float
            Commanded road-wheel angle [rad], left positive.
        a_x : float
            Commanded acceleration [m/s^2].
        dt : float
            Time step [s].
        """
        self._set(self._inputs, [delta, a_x])
        self._fmu.doStep(currentCommunicationPoint=self._t, communicationStepSize=dt)
        self._t += dt
        self._read()

    def close(self) -> None:
        """End the FMU and delete its files."""
        self._fmu.terminate()
        self._fmu.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _set(self, references: list[int], values: list[float]) -> None:
        (self._fmu.setFloat64 if self._is_fmi3 else self._fmu.setReal)(references, values)

    def _read(self) -> None:
        values = (self._fmu.getFloat64 if self._is_fmi3 else self._fmu.getReal)(self._outputs)
        motion = dict(zip(_OUTPUTS, map(float, values), strict=True))
        self.a_y = motion.pop("a_y")
        self._state = VehicleState(**motion)


def _references(name: str, wanted: Mapping[str, str], known: Mapping[str, int]) -> list[int]:
    missing = [each for each in wanted.values() if each not in known]
    if missing:
        raise InputError(f"{name} must name variables of the FMU, had {missing[0]!r}")
    return [known[each] for each in wanted.values()]
