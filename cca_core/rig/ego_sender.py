"""Messages of the ego: its measured motion at 10 Hz."""

import math

import numpy as np

from cca_core.path import LocalFrame
from cca_core.sim.scenarios.scenario import Scenario
from cca_core.sim.world.radio import bsm_of
from cca_core.v2x import Sender, SenderSettings
from cca_core.vehicle import VehicleState


class EgoSender:
    """Sender of the ego, whose clock may be corrected backward."""

    def __init__(self, scenario: Scenario, ego_id: str) -> None:
        self._vehicle, self._is_used, self._id = scenario.vehicle, scenario.v2v, ego_id
        self._frame = LocalFrame(*scenario.origin)
        self._sender, self._last = self._new_sender(), -math.inf

    def poll(self, utc: float, state: VehicleState) -> bytes | None:
        """Return a message if one is due at the senders' time [s]; None without V2V."""
        if utc < self._last:  # the senders' time was found to be earlier
            self._sender = self._new_sender()
        self._last = utc
        if not self._is_used:
            return None
        center = self._vehicle.center_at(state.x, state.y, state.psi)
        motion = (*center, state.psi, max(state.v_x, 0.0), state.a_x, state.r)
        return self._sender.poll(utc, bsm_of("ego", motion, self._vehicle, frozenset()))

    def _new_sender(self) -> Sender:
        return Sender(self._id, self._frame, SenderSettings(), np.random.default_rng(0))
