"""The examples run."""

import csv
import gzip
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "examples"))


def test_a_folder_of_recordings_becomes_one_table(tmp_path):
    import diagnose_folder

    data = HERE.parent / "notebooks" / "data"
    shutil.copy(data / "hysteresis.csv.gz", tmp_path / "a.csv.gz")
    with gzip.open(data / "hysteresis.csv.gz", "rt") as file:
        (tmp_path / "too_short.csv").write_text("".join(file.readlines()[:100]))
    table = tmp_path / "causes" / "table.csv"
    table.parent.mkdir()
    diagnose_folder.main([str(tmp_path), str(data / "rig.toml"), "--out", str(table), "--workers", "1"])
    with table.open() as file:
        rows = list(csv.DictReader(file))
    assert [row["recording"] for row in rows][0] == "a.csv.gz"
    assert "valve_hysteresis" in [row["cause"] for row in rows]
    assert rows[-1]["recording"] == "too_short.csv"
    assert rows[-1]["verdict"] == "failed" and rows[-1]["remark"]
