"""The README's examples run as written."""

import re
from pathlib import Path

import pytest

README = (Path(__file__).parents[1] / "README.md").read_text()
BLOCKS = re.findall(r"^```python\n(.*?)^```", README, flags=re.M | re.S)


def test_there_are_examples():
    assert len(BLOCKS) >= 3


@pytest.mark.parametrize("number", range(len(BLOCKS)))
def test_example(number, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    if "dataset.open" in BLOCKS[number]:
        (tmp_path / "presses.txt").write_text("semi-dome-001\nsemi-dome-002\nsemi-dome-003\n")
        command("dataset", "rtac0", "--presses", "presses.txt", "-o", "rtac0-truth")
    exec(compile(BLOCKS[number], "README.md", "exec"), {})
