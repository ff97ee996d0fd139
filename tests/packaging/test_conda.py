"""The recipe for conda asks for what pip asks for, and a package is built from it that works."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import conda_package
import pytest
from rattler_build import (
    Package,
    PlatformConfig,
    RenderConfig,
    RenderedVariant,
    Stage0Recipe,
    VariantConfig,
)

ROOT = Path(__file__).parents[2]
RECIPE = ROOT / "ci" / "packaging" / "conda" / "recipe.yaml"
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
PROJECT = PYPROJECT["project"]
PYTHON = f"python{PROJECT['requires-python']}"
COMPILERS = {
    "linux-64": "gcc_linux-64",
    "linux-aarch64": "gcc_linux-aarch64",
    "osx-64": "clang_osx-64",
    "osx-arm64": "clang_osx-arm64",
}
"""Platforms for which there are wheels, and conda-forge's compiler of C for each."""


def rendered(platform: str, **versions: list[str]) -> list[RenderedVariant]:
    """The recipe as it is built on a platform, once for each of the versions."""
    config = PlatformConfig(
        target_platform=platform, build_platform=platform, host_platform=platform
    )
    recipe = Stage0Recipe.from_file(RECIPE)
    return recipe.render(VariantConfig(versions), RenderConfig(platform=config))


def plain(requirements: list[Any]) -> set[str]:
    """Requirements as pip writes them. Those that follow from another one are no text."""
    return {line.replace(" ", "") for line in requirements if isinstance(line, str)}


@pytest.mark.parametrize("platform", COMPILERS)
def test_the_recipe_asks_on_every_platform_for_what_pip_asks_for(platform: str) -> None:
    (variant,) = rendered(platform)
    assert variant.recipe.package.version == PROJECT["version"]
    asked = variant.recipe.requirements
    assert plain(asked.run) == {PYTHON, *PROJECT["dependencies"]}
    built_with = {*PYPROJECT["build-system"]["requires"], "python", "pip", COMPILERS[platform]}
    assert plain(asked.host + asked.build) == built_with


def test_a_package_is_named_for_its_version_of_python_and_held_to_it() -> None:
    variants = rendered("linux-64", python=["3.11.*", "3.14.*"])
    names = [str(variant.recipe.build.string) for variant in variants]
    assert [name[:5] for name in names] == ["py311", "py314"]
    for variant in variants:
        (pin,) = [line for line in variant.recipe.requirements.run if not isinstance(line, str)]
        assert pin["pin_compatible"]["name"] == "python"


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Package:
    """The package for this machine, built by the recipe; the recipe's tests have passed."""
    folder = tmp_path_factory.mktemp("conda")
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith("PYTHON")
    }
    subprocess.run(
        [sys.executable, "ci/packaging/conda_package.py", str(folder)],
        cwd=ROOT,
        env=environment,
        check=True,
        timeout=1800,
    )
    (made,) = (folder / "built").glob("*/refdem-*.conda")
    return Package.from_file(made)


def test_the_package_holds_the_command_and_every_kernel(package: Package) -> None:
    assert package.version == PROJECT["version"]
    assert "bin/refdem" in package.files
    families = {path.stem for path in (ROOT / "refdem" / "kernels").glob("*.c")}
    built = {Path(name).name.partition(".")[0] for name in package.files if name.endswith(".so")}
    assert built == {f"_{family}" for family in families}


def test_the_package_is_built_from_the_files_that_git_knows_alone(tmp_path: Path) -> None:
    conda_package.copy_sources(tmp_path)
    made = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()}
    known = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    assert made == set(known.stdout.splitlines())


def test_the_package_holds_nothing_of_other_packages(package: Package) -> None:
    python = f"python{sys.version_info[0]}.{sys.version_info[1]}"
    site = f"lib/{python}/site-packages"
    known = ("bin/refdem", f"{site}/refdem/", f"{site}/refdem-{PROJECT['version']}.dist-info/")
    assert [name for name in package.files if not name.startswith(known)] == []


def test_the_package_is_installed_only_with_the_python_that_built_it(package: Package) -> None:
    major, minor = sys.version_info[:2]
    assert f"python >={major}.{minor},<{major}.{minor + 1}.0a0" in package.depends
