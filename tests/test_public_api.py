"""The public names are a promise: adding or removing one changes this list on purpose."""

import importlib
import pkgutil

import pytest

import cca_core

PUBLIC = """
    Action Band CcaError Command Decision EvasionSettings InfeasibleError InputError Lane LocalFrame
    MissingExtraError Path Planner PreviewController RemoteVehicle Road Status VehicleParams
    VehicleState choose_action danger_zone design_gains fit_path relax_band smooth_band
""".split()

ROOMS = [name for _, name, _ in pkgutil.iter_modules(cca_core.__path__) if not name.startswith("_")]


def test_the_list_is_frozen() -> None:
    assert sorted(cca_core.__all__) == sorted(PUBLIC)


@pytest.mark.parametrize("name", PUBLIC)
def test_name_can_be_imported(name: str) -> None:
    assert getattr(cca_core, name) is not None


@pytest.mark.parametrize("room", ROOMS)
def test_package_names_are_unique_and_exist(room: str) -> None:
    module = importlib.import_module(f"cca_core.{room}")
    names = getattr(module, "__all__", [])
    assert len(names) == len(set(names))
    assert [name for name in names if not hasattr(module, name)] == []


def test_no_name_shadows_a_package() -> None:
    assert not set(cca_core.__all__) & set(ROOMS)
