"""What the diagnosis says of progpy's faults: the right name or none, never a foreign one."""

import json
import multiprocessing
import os
import subprocess

import pytest
from cylinder import RIG, Cylinder

MODEL = os.environ["PNEUDRIVE_MODEL"]
MOVING = dict(spring_n_m=3e4, spring_offset_m=0.05)
"""With this spring the piston leaves the bottom at a quarter of the supply's pressure, and the chambers change their volumes by 40 %."""

LEAK = {"exhaust_leak"}
INTERNAL = {"exhaust_leak", "fill_leak"}
"""A leak between the chambers takes from the fuller one and gives to the emptier; the catalogue has leaks to the air and from the supply."""
PISTON = {"chamber_coupling", "wall_compliance", "wall_creep"}
"""A chamber that its pressure enlarges, that of the other one makes smaller, and that follows with friction."""

RECORDINGS = {
    "calibrated": Cylinder(41_001),
    "calibrated_moving": Cylinder(41_002, **MOVING),
    **{f"sound_{n}": Cylinder(41_010 + n) for n in range(6)},
    **{f"bottom_leak_{p}": Cylinder(41_020 + p, bottom_leak=p / 100) for p in (2, 5, 15)},
    **{f"top_leak_{p}": Cylinder(41_040 + p, top_leak=p / 100) for p in (2, 5, 15)},
    **{f"internal_leak_{p}": Cylinder(41_060 + p, internal_leak=p / 100) for p in (2, 5, 15)},
    **{f"moving_{n}": Cylinder(41_080 + n, **MOVING) for n in range(3)},
    "moving_rubs": Cylinder(41_091, **MOVING, friction_n_s_m=6e4),
    "moving_weak_spring": Cylinder(41_092, **{**MOVING, "spring_n_m": 2.4e4}),
    "moving_bottom_leak_5": Cylinder(41_093, **MOVING, bottom_leak=0.05),
}

# Of which recording, against which calibrated one, which names are no foreign ones, and which must
# be there.
ASKED = (
    [(f"sound_{n}", None, set(), set()) for n in range(6)]
    + [(f"sound_{n}", "calibrated", set(), set()) for n in range(6)]
    # A leak is a part of the model that is fitted.
    + [(f"{where}_leak_{p}", None, set(), set()) for where in ("bottom", "top", "internal") for p in (2, 5, 15)]
    + [(f"{where}_leak_{p}", "calibrated", LEAK, set()) for where in ("bottom", "top") for p in (2,)]
    + [(f"{where}_leak_{p}", "calibrated", LEAK, LEAK) for where in ("bottom", "top") for p in (5, 15)]
    + [(f"internal_leak_{p}", "calibrated", INTERNAL, set()) for p in (2, 5, 15)]
    + [(name, None, PISTON, set()) for name in ("moving_0", "moving_1", "moving_2")]
    + [(f"moving_{n}", "calibrated_moving", set(), set()) for n in range(3)]
    + [(name, "calibrated_moving", set(), set()) for name in ("moving_rubs", "moving_weak_spring")]
    + [("moving_bottom_leak_5", "calibrated_moving", LEAK, set())]
)


def record(name, folder):
    RECORDINGS[name].record(folder / f"{name}.csv")


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """All recordings, and the models of the two calibrated ones."""
    folder = tmp_path_factory.mktemp("progpy")
    (folder / "rig.toml").write_text(RIG)
    with multiprocessing.Pool() as pool:
        pool.starmap(record, [(name, folder) for name in RECORDINGS])
    for name in ("calibrated", "calibrated_moving"):
        diagnosed(folder, name)
    print("\n| recording | question | verdict | named | error, kPa |\n|---|---|---|---|--:|")
    return folder


def diagnosed(folder, name, reference=None):
    out = folder / f"{name}-since-{reference}" if reference else folder / name
    question = ["--reference", folder / reference / "extended.toml"] if reference else []
    command = [MODEL, "diagnose", folder / f"{name}.csv", "--rig", folder / "rig.toml", "--out", out, *question]
    subprocess.run(command, check=True, capture_output=True, timeout=600)
    return json.loads((out / "report.json").read_text())


@pytest.mark.parametrize(("name", "reference", "possible", "needed"), ASKED, ids=[f"{a[0]}-{a[1] or 'structure'}" for a in ASKED])
def test_no_foreign_name(folder, name, reference, possible, needed):
    report = diagnosed(folder, name, reference)
    named = {cause["effect"]: cause["channels"] for cause in report["causes"]}
    shown = "; ".join(f"`{effect}` on {', '.join(channels)}" for effect, channels in named.items())
    before, after = report["baseline"]["test_rmse_kpa"], report["unexplained"]["test_rmse_kpa"]
    question = "what has changed" if reference else "what is missing"
    print(f"| {name.replace('_', ' ')} | {question} | {report['verdict'].replace('_', ' ')} | {shown} | {before:.2f} to {after:.2f} |")
    assert set(named) <= possible
    assert needed <= set(named)
    if "exhaust_leak" in named and "internal" not in name:
        assert named["exhaust_leak"] == ["b0c0" if "bottom" in name else "b0c1"]
