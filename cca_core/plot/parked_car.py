"""The example of the figures of bands: a straight route past a parked car."""

from dataclasses import dataclass

from cca_core.geometry import Boxes, boxes
from cca_core.vehicle import VehicleParams


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkedCar:
    """A parked car, the ego that passes it, and what is asked of the band."""

    vehicle: VehicleParams
    length: float = 4.5  # of the parked car [m]
    width: float = 1.8  # [m]
    clearance: float = 1.0  # that is asked [m]
    speed: float = 20.0  # at which lateral accelerations are given [m/s]
    route_length: float = 100.0  # the car stands in the middle [m]
    d: float = -0.5  # lateral offset of the car [m]
    k_e: float = 0.03  # external per spring stiffness of the band as printed [-]

    @property
    def contact_distance(self) -> float:
        """Lateral distance of the centers at which the bodies have no gap [m]."""
        return 0.5 * (self.width + self.vehicle.width)

    @property
    def r_0(self) -> float:
        """Lateral distance of the centers that gives the clearance [m]."""
        return self.contact_distance + self.clearance

    def body(self, d: float) -> Boxes:
        """Box of the parked car at a lateral offset [m]."""
        return boxes(0.5 * self.route_length, d, 0.0, self.length, self.width)


EXAMPLE = ParkedCar(vehicle=VehicleParams.bmw_320i())
