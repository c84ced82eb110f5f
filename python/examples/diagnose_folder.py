"""Diagnoses every recording in a folder, in parallel, and writes one table.

    python diagnose_folder.py recordings/ rig.toml --out causes.csv                        # on this machine
    python diagnose_folder.py recordings/ rig.toml --out causes.csv --scheduler tcp://head:8786   # on a Dask cluster

A recording that cannot be diagnosed is a row with the reason, and does not stop the others. On a cluster the folder must be
readable by the workers under the same path.
"""

import argparse
import csv
import os
from pathlib import Path

import dask
from dask.distributed import Client, LocalCluster, as_completed

COLUMNS = [
    "recording", "verdict", "cause", "channels", "size", "error_before_kpa", "error_after_kpa", "gain", "fits_as_well", "remark",
]  # fmt: skip


def diagnose_one(path, rig):
    """One recording: a list of rows, one per cause, one in all where none was named."""
    import pneudrive_py as pneu

    row = dict.fromkeys(COLUMNS, "") | {"recording": Path(path).name}
    try:
        recording = pneu.load(path, rig)
        diagnosis = pneu.diagnose(recording, rig)
    except pneu.PneuDriveError as error:
        return [row | {"verdict": "failed", "remark": str(error)}]
    row |= {"verdict": diagnosis.verdict, "remark": diagnosis.sentence}
    baseline = diagnosis.report_dict["baseline"]["test_rmse_kpa"]
    if not diagnosis.causes:
        return [row | {"error_before_kpa": f"{baseline:.3f}", "error_after_kpa": f"{baseline:.3f}"}]
    return [row | columns_of(cause) for cause in diagnosis.causes]


def columns_of(cause):
    sizes = [f"{name} {value['value']:.4g} {value['unit']}" for name, value in cause["parameters"].items()]
    gain = cause["gain"]
    return {
        "cause": cause["effect"],
        "channels": " ".join(cause["channels"]),
        "size": "; ".join(sizes),
        "error_before_kpa": f"{gain['test_rmse_before_kpa']:.3f}",
        "error_after_kpa": f"{gain['test_rmse_after_kpa']:.3f}",
        "gain": f"{gain['reduction']:.3f}",
        "fits_as_well": " ".join(cause["equivalent"]),
    }


def local_cluster(workers):
    """Processes on this machine, one thread each inside and out: together they use every core once."""
    dask.config.set({"distributed.nanny.pre-spawn-environ.RAYON_NUM_THREADS": "1"})
    return LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None)


def diagnose_all(client, paths, rig):
    """All rows, in the order of the recordings."""
    futures = {client.submit(diagnose_one, str(path), str(rig), pure=False): path for path in paths}
    rows = {}
    for done, future in enumerate(as_completed(futures), start=1):
        rows[futures[future]] = future.result()
        print(f"{done}/{len(paths)} {futures[future].name}: {rows[futures[future]][0]['verdict']}")
    return [row for path in paths for row in rows[path]]


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="CSV files, plain or compressed")
    parser.add_argument("rig", type=Path, help="rig file of all of them")
    parser.add_argument("--out", type=Path, default=Path("causes.csv"), help="table to write")
    parser.add_argument("--scheduler", help="address of a Dask scheduler; default: processes on this machine")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="number of local processes")
    options = parser.parse_args(arguments)
    paths = sorted(path.resolve() for path in options.folder.glob("*.csv*"))
    if not paths:
        parser.error(f"{options.folder}: no *.csv, *.csv.gz or *.csv.zst")
    cluster = None if options.scheduler else local_cluster(min(options.workers, len(paths)))
    with Client(cluster or options.scheduler) as client:
        rows = diagnose_all(client, paths, options.rig.resolve())
    if cluster:
        cluster.close()
    with options.out.open("w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        table.writerows(rows)
    print(f"wrote {options.out}: {len(rows)} rows")


if __name__ == "__main__":
    main()
