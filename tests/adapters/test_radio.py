"""Messages of the vehicles of another world."""

import numpy as np
import pytest

from cca_core import RemoteVehicle, VehicleState
from cca_core.adapters import RadioLink
from cca_core.path import LocalFrame
from cca_core.v2x import Channel, ChannelSettings

EGO = VehicleState(x=0.0, y=0.0, psi=0.0, v_x=20.0)


@pytest.mark.parametrize(("r", "a_x"), [(6.0, 0.0), (-8.0, 30.0), (0.1, -25.0)])
def test_motion_that_jumps_hides_no_other_vehicle(r: float, a_x: float) -> None:
    rng = np.random.default_rng(1)
    link = RadioLink(LocalFrame(40.0, -83.0), Channel(ChannelSettings(), rng), rng)
    known: tuple[RemoteVehicle, ...] = ()
    for k in range(10):
        jumps = RemoteVehicle(id="a", x=30.0 + 2.0 * k, y=0.0, psi=0.0, v_x=20.0, a_x=a_x, r=r)
        steady = RemoteVehicle(id="b", x=60.0 + 2.0 * k, y=3.5, psi=0.0, v_x=20.0)
        known = link.exchange(0.1 * k, [jumps, steady], EGO)
    assert "b" in [vehicle.id for vehicle in known]
