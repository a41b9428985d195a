"""The public names: adding or removing one must change this list."""

import importlib
import pkgutil

import pytest

import cca_core

PUBLIC = """
    Action Band CcaError Command Decision EvasionSettings InfeasibleError InputError Lane LocalFrame
    MissingExtraError Path Planner PreviewController RemoteVehicle Road Status VehicleParams
    VehicleState choose_action danger_zone design_gains fit_path relax_band smooth_band
""".split()

PACKAGES = [name for _, name, _ in pkgutil.iter_modules(cca_core.__path__) if not name.startswith("_")]


def test_top_level_names_are_frozen() -> None:
    assert sorted(cca_core.__all__) == sorted(PUBLIC)


@pytest.mark.parametrize("name", PUBLIC)
def test_top_level_name_is_importable(name: str) -> None:
    assert getattr(cca_core, name) is not None


@pytest.mark.parametrize("package", PACKAGES)
def test_package_names_are_unique_and_exist(package: str) -> None:
    module = importlib.import_module(f"cca_core.{package}")
    names = getattr(module, "__all__", [])
    assert len(names) == len(set(names))
    assert [name for name in names if not hasattr(module, name)] == []


def test_top_level_names_shadow_no_package() -> None:
    assert not set(cca_core.__all__) & set(PACKAGES)


def test_packages_share_no_name() -> None:
    names = [
        name
        for package in PACKAGES
        for name in getattr(importlib.import_module(f"cca_core.{package}"), "__all__", [])
    ]
    assert sorted(names) == sorted(set(names))
