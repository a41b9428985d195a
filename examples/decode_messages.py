"""From bytes to vehicles: decode Basic Safety Messages, track their senders, predict their positions."""

from cca_core import LocalFrame
from cca_core.v2x import Bsm, Tracker, decode_bsm, encode_bsm

frame = LocalFrame(40.0, -83.0)
tracker = Tracker(frame)

log = []  # (time of reception [s], bytes), as from a modem or a file; synthetic here
for k in range(20):
    t = 0.1 * k
    lat, lon = frame.to_geodetic((30.0 + 15.0 * t, 2.0))
    bsm = Bsm(
        msg_count=k, id="00c0ffee", sec_mark=t, latitude_deg=float(lat), longitude_deg=float(lon), speed=15.0,
        psi=0.0, a_x=-4.0 if k == 19 else 0.0, length=4.5, width=1.8,
        events=frozenset({"hard_braking"} if k == 19 else ()),
    )  # fmt: skip
    log.append((t + 0.03, encode_bsm(bsm)))
log.insert(10, (1.0, b"not a message"))

for t_received, data in log:
    result = tracker.update(data, t_received)
    if not result.accepted:
        print(f"dropped at {t_received:.2f} s: {result.kind}")
print(decode_bsm(log[-1][1]))

for t in (2.0, 3.0, 4.0):
    for car in tracker.vehicles(t):
        print(
            f"{t:.1f} s: {car.id} at {car.x:.1f} m east, {car.y:.1f} m north, {car.v_x:.1f} m/s, "
            f"age {car.age:.1f} s, along-track 2 sigma {2.0 * car.sigma_along:.1f} m, {sorted(car.events)}"
        )
