"""The wheel that brings the program and the package, and the source distribution."""

import os
import re
import runpy
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest
from conftest import ROOT, binary

PACKAGE = ROOT / "plugins/python"

platform_of = runpy.run_path(str(PACKAGE / "hatch_build.py"))["platform_of"]


def build(folder: Path, program: Path | None = None, source: Path = PACKAGE) -> zipfile.ZipFile:
    """Builds a wheel as pip does, but without a download."""
    environment = {name: value for name, value in os.environ.items() if name != "REGATTA_WHEEL_PROGRAM"}
    if program is not None:
        environment["REGATTA_WHEEL_PROGRAM"] = str(program)
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(command, cwd=source, env=environment, check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    return zipfile.ZipFile(wheel)


def version() -> str:
    """Returns the version that the program says."""
    said = subprocess.run([binary(), "--version"], check=True, capture_output=True, text=True).stdout
    match = re.match(r"regatta (\S+)", said)
    assert match is not None, said
    return match[1]


@pytest.mark.skipif(sys.platform != "linux", reason="the tags of other platforms are those of Python")
def test_a_wheel_with_the_program_is_for_its_platform(tmp_path: Path) -> None:
    program = tmp_path / "regatta"
    program.symlink_to(binary())
    with build(tmp_path, program) as wheel:
        name = Path(str(wheel.filename)).name
        assert re.fullmatch(rf"regatta_sim-{version()}-py3-none-manylinux_2_\d+_(x86_64|aarch64)\.whl", name), name
        script = f"regatta_sim-{version()}.data/scripts/regatta"
        metadata = wheel.read(f"regatta_sim-{version()}.dist-info/WHEEL").decode()
        assert "Root-Is-Purelib: false" in metadata and f"Tag: {name.split('-', 2)[2].removesuffix('.whl')}" in metadata
        assert {"regatta/__init__.py", "regatta/layout.json", "regatta/py.typed"} <= set(wheel.namelist())
        assert wheel.getinfo(script).external_attr >> 16 & 0o111 == 0o111, "pip installs it as an executable"
        wheel.extract(script, tmp_path)
    (tmp_path / script).chmod(0o755)
    runs = subprocess.run([tmp_path / script, "--version"], capture_output=True, text=True)
    assert runs.returncode == 0 and version() in runs.stdout


def test_a_wheel_without_the_program_is_for_all_platforms(tmp_path: Path) -> None:
    with build(tmp_path) as wheel:
        assert Path(str(wheel.filename)).name == f"regatta_sim-{version()}-py3-none-any.whl"
        assert not [name for name in wheel.namelist() if "scripts" in name]


def test_a_source_distribution_builds_outside_of_the_repository(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", str(tmp_path)]
    subprocess.run(command, cwd=PACKAGE, check=True, capture_output=True)
    (source,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(source) as archive:
        assert not [member.name for member in archive if member.issym()], "a link would lead nowhere"
        archive.extractall(tmp_path, filter="data")
    (tmp_path / "elsewhere").mkdir()
    unpacked = tmp_path / source.name.removesuffix(".tar.gz")
    with build(tmp_path / "elsewhere", source=unpacked) as elsewhere, build(tmp_path) as here:
        assert Path(str(elsewhere.filename)).name == Path(str(here.filename)).name
        assert sorted(elsewhere.namelist()) == sorted(here.namelist())
        licences = f"regatta_sim-{version()}.dist-info/licenses"
        for name in ("LICENSE-APACHE", "LICENSE-MIT"):
            assert elsewhere.read(f"{licences}/{name}") == (ROOT / name).read_bytes()


def test_the_platform_is_the_oldest_that_can_run_the_program() -> None:
    def elf(machine: int, *symbols: bytes) -> bytes:
        return b"\x7fELF" + bytes(14) + machine.to_bytes(2, "little") + b"\0".join([b"", *symbols, b""])

    assert platform_of(elf(0x3E, b"GLIBC_2.2.5", b"GLIBC_2.34", b"GLIBC_2.9")) == "manylinux_2_34_x86_64"
    assert platform_of(elf(0xB7, b"GLIBC_2.17")) == "manylinux_2_17_aarch64"
    assert re.fullmatch(r"[a-z0-9_]+", platform_of(b"MZ another format")), "the platform of this Python"
