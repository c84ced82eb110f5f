"""What an installer and a package index see."""

import importlib.metadata
import re
from pathlib import Path

from pneudrive_py import __main__ as program

FOLDER = Path(__file__).resolve().parents[1]


def test_the_metadata_is_complete():
    said = importlib.metadata.metadata("pneudrive_py")
    for field in ("Summary", "License-Expression", "Requires-Python", "Keywords", "Author", "Classifier", "Project-URL"):
        assert said.get(field), field
    assert {Path(name).name for name in said.get_all("License-File")} == {"LICENSE-MIT", "LICENSE-APACHE"}
    assert said["Description-Content-Type"].startswith("text/markdown")


def test_the_command_is_the_programs_main():
    commands = importlib.metadata.entry_points(group="console_scripts", name="pneudrive")
    assert [command.load() for command in commands] == [program.main]


def test_the_readme_stands_alone():
    """On a package index a link into the repository leads nowhere."""
    links = re.findall(r"\]\(([^)]+)\)", (FOLDER / "README.md").read_text())
    assert [link for link in links if not link.startswith(("https://", "#"))] == []
