"""Library, FMI unit and MuJoCo plugin for Linux on aarch64, under qemu, give the numbers of those for x86-64."""

import os
import platform
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
import zipfile

import mujoco
import numpy as np
import pytest

from conftest import FOLDER, MODEL, PARAMETERS, model
from test_mujoco import chamber, world

LIBRARY = os.path.abspath(os.environ.get("PNEUDRIVE_AARCH64", "nowhere"))
NATIVE = os.path.join(os.path.dirname(os.path.abspath(MODEL)), "libpneudrive_capi.so")
COMPILER, EMULATOR, SYSROOT = "aarch64-linux-gnu-gcc", "qemu-aarch64", "/usr/aarch64-linux-gnu"
MUJOCO = os.path.abspath(os.environ.get("PNEUDRIVE_AARCH64_MUJOCO", "nowhere"))
#: kPa. Mathematical functions of two C libraries may differ in the last digit.
MOST_KPA = 1e-9

MISSING = [
    *(f"{program} ({package})" for program, package in [(COMPILER, "gcc-aarch64-linux-gnu"), (EMULATOR, "qemu-user")] if not shutil.which(program)),
    *([] if os.path.isfile(LIBRARY) else ["the library, which capi/cross/aarch64 builds"]),
]
pytestmark = [
    pytest.mark.skipif(platform.machine() != "x86_64", reason=f"compares with x86-64; this is {platform.machine()}"),
    pytest.mark.skipif(bool(MISSING), reason=f"AARCH64 IS NOT TRIED: missing {', '.join(MISSING)}"),
]


def programs(folder, source, *options):
    """A program for both machines, as commands."""
    native, foreign = folder / "native", folder / "foreign"
    warnings = ["-Wall", "-Wextra", "-Werror", "-Wno-pedantic", "-O1"]
    for compiler, out, library in [("cc", native, NATIVE), (COMPILER, foreign, LIBRARY)]:
        subprocess.run([compiler, *warnings, source, "-o", out, *(o.format(library=library) for o in options)], check=True)
    return [str(native)], [EMULATOR, "-L", SYSROOT, str(foreign)]


def output(command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_c_library_gives_the_same_numbers(tmp_path):
    include = FOLDER.parents[1] / "include"
    native, foreign = programs(tmp_path, FOLDER.parents[1] / "examples" / "step.c", f"-I{include}", "{library}", "-lm")
    arguments = [PARAMETERS, "b0c1", 150]
    found = []
    for command in (native, foreign):
        rows = output([*command, *arguments]).splitlines()[1:]
        found.append(np.array([[float(v) for v in row.split(",")] for row in rows]))
    here, there = found
    # Printed to six digits after the point.
    assert here.shape == (2000, 4) and np.abs(there - here).max() <= 2e-6
    assert here[-1, 1] > 100


def test_a_unit_for_both_machines_gives_the_same_numbers(tmp_path):
    path = tmp_path / "chambers.fmu"
    model("export", "fmu", "--parameters", PARAMETERS, "--out", path, "--also", LIBRARY)
    with zipfile.ZipFile(path) as zipped:
        zipped.extractall(tmp_path / "unit")
    token = ElementTree.parse(tmp_path / "unit" / "modelDescription.xml").getroot().get("instantiationToken")
    native, foreign = programs(tmp_path, FOLDER / "programs" / "unit.c", "-ldl")
    found = []
    for command, machine in [(native, "x86_64-linux"), (foreign, "aarch64-linux")]:
        library = tmp_path / "unit" / "binaries" / machine / "pneudrive_chamber.so"
        rows = output([*command, library, tmp_path / "unit" / "resources", token, 4]).splitlines()
        found.append(np.array([[float(v) for v in row.split()] for row in rows]))
    here, there = found
    largest = np.abs(there - here).max()
    print(f"\nunit on aarch64: at most {largest:.1e} kPa from x86-64, {np.mean(here == there):.1%} of the numbers the same to the bit")
    assert here.shape == (3000, 4) and largest < MOST_KPA
    assert np.ptp(here, axis=0).min() > 100, "nothing moves"


def test_the_mujoco_plugin_gives_the_same_numbers(exported, tmp_path):
    foreign_export = tmp_path / "foreign"
    model("export", "mujoco", "--parameters", PARAMETERS, "--out", foreign_export, "--library", LIBRARY)
    environment = os.environ | {"CC": COMPILER, "MUJOCO": MUJOCO}
    subprocess.run(["sh", foreign_export / "build.sh"], check=True, env=environment)
    robot = tmp_path / "robot.xml"
    robot.write_text(world(chamber(name="b0c2")))
    [version] = [name for name in os.listdir(MUJOCO) if name.startswith("libmujoco.so")]
    here = os.path.dirname(mujoco.__file__)
    found = []
    for compiler, folder, plugin, run in [
        ("cc", here, exported, []),
        (COMPILER, MUJOCO, foreign_export, [EMULATOR, "-L", SYSROOT]),
    ]:
        program = tmp_path / os.path.basename(compiler)
        source = FOLDER / "programs" / "plugin.c"
        options = ["-Wall", "-Wextra", "-Werror", "-isystem", f"{folder}/include", f"{folder}/{version}", f"-Wl,-rpath,{folder}"]
        subprocess.run([compiler, source, "-o", program, *options], check=True)
        rows = output([*run, program, plugin / "libpneudrive_actuator.so", robot]).splitlines()
        found.append(np.array([[float(v) for v in row.split()] for row in rows]))
    native, foreign = found
    # Pressure, kPa, and angle, rad.
    largest = np.abs(foreign - native).max(axis=0)
    print(f"\nplugin on aarch64: at most {largest[0]:.1e} kPa and {largest[1]:.1e} rad from x86-64")
    assert native.shape == (3000, 2) and largest[0] < MOST_KPA and largest[1] < 1e-9
    assert (np.ptp(native, axis=0) > [100, 0.05]).all(), "nothing moves"
