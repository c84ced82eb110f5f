"""A continuum joint follows the set points of a trajectory file, as `pneudrive-host --trajectory` sends them to boards.

    python joint.py EXPORT_FOLDER PARAMETERS.toml TRAJECTORY.csv OUT.csv [PICTURE.svg]

EXPORT_FOLDER is what `pneudrive-model export mujoco` wrote and build.sh built. The trajectory has the columns t_s and b0_cmd0_kpa to
b0_cmd3_kpa (`pneudrive-host generate` makes one); OUT.csv is a recording of the joint: commands, pressures, angles.
The picture needs matplotlib.
"""

import csv
import sys
from pathlib import Path

import mujoco
import numpy as np

ROW_S = 0.01


def simulate(folder, parameters, trajectory):
    """Rows of time, four commands, four pressures and two angles, every 10 ms."""
    mujoco.mj_loadPluginLibrary(str(Path(folder).resolve() / "libpneudrive_actuator.so"))
    xml = (Path(__file__).parent / "joint.xml").read_text().replace("PARAMETERS", str(Path(parameters).resolve()))
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    lines = [line for line in Path(trajectory).read_text().splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    times = np.array([float(row["t_s"]) for row in rows])
    commands = np.array([[float(row[f"b0_cmd{k}_kpa"]) for k in range(4)] for row in rows])
    steps = round(ROW_S / model.opt.timestep)
    table = []
    for k in range(round(times[-1] / ROW_S)):
        # A set point holds until the next one; before the first, nothing is commanded.
        at = np.searchsorted(times, k * ROW_S + 1e-9, side="right") - 1
        data.ctrl[:] = commands[at] if at >= 0 else 0.0
        table.append([k * ROW_S, *data.ctrl, *data.act, *data.qpos])
        mujoco.mj_step(model, data, nstep=steps)
    return np.array(table)


def draw(table, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(8, 5), layout="constrained")
    for k in range(4):
        (line,) = above.plot(table[:, 0], table[:, 5 + k], label=f"b0c{k}")
        above.plot(table[:, 0], table[:, 1 + k], "--", color=line.get_color(), linewidth=0.8)
    above.set_ylabel("pressure (kPa gauge)")
    above.legend(ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0), title="solid: simulated, dashed: set points")
    for k, name in enumerate(["qu", "qv"]):
        below.plot(table[:, 0], np.degrees(table[:, 9 + k]), label=name)
    below.set_ylabel("angle (degrees)")
    below.set_xlabel("time (s)")
    below.legend(ncols=2, loc="lower left")
    figure.savefig(path)


def main():
    if len(sys.argv) not in (5, 6):
        sys.exit(__doc__)
    table = simulate(*sys.argv[1:4])
    names = ["t_s", *(f"b0_cmd{k}_kpa" for k in range(4)), *(f"b0_p{k}_kpa" for k in range(4)), "b0_qu_rad", "b0_qv_rad"]
    np.savetxt(sys.argv[4], table, fmt="%.6g", delimiter=",", header=",".join(names), comments="")
    if len(sys.argv) == 6:
        draw(table, sys.argv[5])


if __name__ == "__main__":
    main()
