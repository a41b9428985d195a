"""Scenarios described in TOML (docs/command_line.md)."""

import math
from dataclasses import fields, replace
from pathlib import Path as FilePath
from typing import Any

from cca_core._checks import shown
from cca_core.cli.road_table import Frame, read_path, read_road
from cca_core.cli.tables import Table, read_toml
from cca_core.errors import InputError
from cca_core.follow import SpeedSettings
from cca_core.path import Road
from cca_core.planner.settings import EvasionSettings
from cca_core.sim import (
    EGO_TYPES,
    PLANTS,
    BrakeAction,
    FixedTimeGap,
    LateralShiftAction,
    ReactToLeadAction,
    RoadUser,
    Scenario,
    SpeedAction,
)
from cca_core.v2x import ChannelSettings, SenderSettings
from cca_core.vehicle import VehicleParams

__all__ = ["read_scenario", "scenario_of"]

_ACTIONS: dict[str, type[Any]] = {
    "brake": BrakeAction, "speed": SpeedAction, "lateral_shift": LateralShiftAction,
    "react_to_lead": ReactToLeadAction,
}  # fmt: skip
_VEHICLES = {
    "bmw_320i": VehicleParams.bmw_320i, "ford_escort": VehicleParams.ford_escort,
    "vw_vanagon": VehicleParams.vw_vanagon,
}  # fmt: skip
_SETTINGS = {
    "default": EvasionSettings, "traffic": EvasionSettings.traffic, "cautious": EvasionSettings.cautious,
    "paper": EvasionSettings.paper,
}  # fmt: skip
_CHANNELS = {"perfect": lambda: ChannelSettings(latency=0.1), "wyoming": ChannelSettings.wyoming}
_SENDERS = {"perfect": SenderSettings, "wyoming": SenderSettings.wyoming}
_TOP = (
    "name", "case", "duration", "seed", "plant", "visibility", "road", "ego", "evasion", "speed", "radio",
    "sender", "road_users", "hazard_id",
)  # fmt: skip
_EGO_REALS = "reaction_time", "sensor_range", "field_of_view", "sensor_delay"
_EGO = ("type", "start", "v_x", "cruise_speed", "vehicle", "fixed_gap", *_EGO_REALS)
_USER = tuple(field.name for field in fields(RoadUser))
# what a message can hold, and a road vehicle can do
_LIMITS = {
    "v_x": (0.0, 160.0), "cruise_speed": (-math.inf, 160.0), "length": (0.01, 40.95), "width": (0.01, 10.23),
    "deceleration": (0.0, 20.0), "acceleration": (0.0, 20.0),
}  # fmt: skip
_START = 20.0  # from the begin of the road [m]


def read_scenario(file: FilePath) -> tuple[Scenario, str]:
    """Return the scenario in a file, and the plant of its ego."""
    return scenario_of(read_toml(file), file)


def scenario_of(top: Table, file: FilePath) -> tuple[Scenario, str]:
    """Return the scenario of a table; other files are named relative to `file`."""
    top.check_keys(_TOP)
    top.require("road")
    top.require("ego")
    folder = file.parent
    road, frame = read_road(top.table("road"), folder)
    radio = dict(top.table("radio").content)
    shared_modem = radio.pop("shared_modem", False)
    if not isinstance(shared_modem, bool):
        raise InputError(f"radio.shared_modem must be true or false, was {shown(shared_modem)}")
    users = tuple(_road_user(each, folder, frame) for each in top.tables("road_users"))
    _check_ids(users)
    ego = top.table("ego")
    scenario = Scenario(
        name=top.text("name", file.stem),
        case=top.text("case") if "case" in top.content else None,
        road=road, road_users=users, **_ego(ego, road, users),
        evasion=top.table("evasion").record(EvasionSettings, _SETTINGS),
        speed=top.table("speed").record(SpeedSettings),
        duration=top.number("duration", 40.0, gt=0.0, le=3600.0),
        seed=top.whole("seed", 1),
        visibility=_infinite(top, "visibility"),
        channel=Table(radio, "radio").record(ChannelSettings, _CHANNELS),
        shared_modem=shared_modem, hazard_id=_hazard_id(top, users),
        sender=top.table("sender").record(SenderSettings, _SENDERS),
    )  # fmt: skip
    return scenario, top.choice("plant", PLANTS, next(iter(PLANTS)))


def _ego(table: Table, road: Road, users: tuple[RoadUser, ...]) -> dict[str, Any]:
    """Return the fields of a scenario that describe its ego."""
    table.check_keys(_EGO)
    _check_limits(table)
    _check_limits(table.table("vehicle"))
    begin, end = road.path.start, road.path.end
    cruise_speed = table.number("cruise_speed", gt=0.0)
    made: dict[str, Any] = {
        "ego_type": table.choice("type", EGO_TYPES, "v2v"),
        "cruise_speed": cruise_speed,
        "v_x": table.number("v_x", cruise_speed, ge=0.0),
        "start": table.number("start", min(begin + _START, end), ge=begin, le=end),
        "vehicle": table.table("vehicle").record(VehicleParams, _VEHICLES),
    }
    for name in _EGO_REALS:
        if name in table.content:
            made[name] = table.number(name, ge=0.0, le=math.tau if name == "field_of_view" else math.inf)
    if "fixed_gap" in table.content:
        gap = table.table("fixed_gap")
        made["fixed_gap"] = gap.record(FixedTimeGap)
        gap.choice("lead_id", [user.id for user in users])
    return made


def _road_user(table: Table, folder: FilePath, frame: Frame) -> RoadUser:
    """Return a road user."""
    route = None if "route" not in table.content else read_path(table.table("route"), folder, frame)
    actions = [_action(each) for each in table.tables("actions")]
    rest = {key: value for key, value in table.content.items() if key not in ("route", "actions")}
    table.check_keys(_USER)
    for key in ("id", "s", "v_x"):
        table.require(key)
    v_x = table.content["v_x"]
    if isinstance(v_x, float | int) and v_x < 0.0:
        raise InputError(
            f"{table.position('v_x')} must be at least 0, with direction = -1 for an oncoming road user, "
            f"was {v_x:g}"
        )
    _check_limits(table)
    user = Table({"d": 0.0, **rest}, table.where).record(RoadUser)
    return replace(user, route=route, actions=tuple(actions))


def _check_limits(table: Table) -> None:
    """Raise if a value is outside the limits of messages and road vehicles."""
    for key, (low, high) in _LIMITS.items():
        if isinstance(table.content.get(key), float | int):
            table.number(key, ge=low, le=high)


def _action(table: Table) -> Any:
    _check_limits(table)
    kind = table.choice("type", _ACTIONS)
    rest = {key: value for key, value in table.content.items() if key != "type"}
    return Table(rest, table.where).record(_ACTIONS[kind])


def _check_ids(users: tuple[RoadUser, ...]) -> None:
    """Raise if an id is used twice, or a lead is unknown."""
    ids = [user.id for user in users]
    for i, user in enumerate(users):
        if user.id in ids[:i]:
            raise InputError(f"road_users[{i}].id must be used once, was {user.id!r} again")
        for j, action in enumerate(user.actions):
            if isinstance(action, ReactToLeadAction) and action.lead_id not in set(ids) - {user.id}:
                raise InputError(
                    f"road_users[{i}].actions[{j}].lead_id must be the id of another road user, "
                    f"was {action.lead_id!r}"
                )


def _hazard_id(top: Table, users: tuple[RoadUser, ...]) -> str | None:
    """Return the id of the road user whose first message warns, in studies."""
    return top.choice("hazard_id", [user.id for user in users]) if "hazard_id" in top.content else None


def _infinite(table: Table, key: str) -> float:
    """Return a positive number that may be infinite, as it is by default."""
    return math.inf if table.content.get(key, math.inf) == math.inf else table.number(key, gt=0.0)
