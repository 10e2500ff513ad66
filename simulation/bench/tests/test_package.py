"""The package has fabkit's version, is left out of fabkit's wheel, and keeps its former name."""

from __future__ import annotations

import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import fabkit
import fabkit_bench

ROOT = Path(__file__).parents[3]


def test_both_packages_have_one_version_and_ask_for_each_other() -> None:
    version = fabkit.__version__
    assert metadata.version("fabkit-bench") == version
    assert f"fabkit-cad=={version}" in (metadata.requires("fabkit-bench") or [])
    assert f"fabkit-bench=={version} ; extra == 'bench'" in (metadata.requires("fabkit-cad") or [])


def test_the_core_package_has_no_experiment() -> None:
    files = [str(file) for file in metadata.files("fabkit-cad") or []]
    assert "fabkit/depth.py" in files
    assert not [file for file in files if "bench" in file and file != "fabkit/bench.py"]


def _run(code: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)


def test_the_former_name_is_the_package_and_says_so() -> None:
    done = _run(
        "import warnings; warnings.simplefilter('error', DeprecationWarning)\n"
        "try:\n    import fabkit.bench\nexcept DeprecationWarning as warning:\n    print(warning)\n"
        "warnings.simplefilter('ignore')\n"
        "import fabkit.bench, fabkit_bench\n"
        "from fabkit import bench\n"
        "from fabkit.bench import Report, dome, run\n"
        "assert bench is fabkit_bench is fabkit.bench and run is fabkit_bench.run\n"
        "from fabkit.bench.__main__ import main\n"
    )
    assert (done.returncode, done.stdout) == (0, "fabkit.bench is called fabkit_bench now\n"), done
    for module in ("fabkit.bench", "fabkit.bench.network"):
        command = [sys.executable, "-m", module, "--help"]
        assert "usage: python -m fabkit_bench" in subprocess.check_output(command, text=True)


def test_without_the_package_the_extra_is_named() -> None:
    hidden = "import sys; sys.modules['fabkit_bench'] = None\n"
    done = _run(hidden + "import fabkit.bench")
    assert done.returncode == 1
    assert re.search(r"ImportError: .* pip install 'fabkit-cad\[bench\]'", done.stderr)
    plan = "{'sensor': 'rtac0', 'axes': {'camera.depth': ['7 mm']}, 'metrics': ['depth_mae_mm']}"
    done = _run(f"{hidden}import fabkit\nfabkit.sweep.load({plan}).evaluate(0)")
    assert done.returncode == 1
    assert "fabkit-bench, which is not installed" in done.stderr
    assert "fabkit-cad[bench]" in done.stderr


def test_the_readme_runs(capsys) -> None:
    readme = (ROOT / "simulation/bench/README.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```", readme, flags=re.M | re.S)
    assert len(blocks) == 1
    exec(compile(blocks[0], "README.md", "exec"), {})
    assert len(capsys.readouterr().out.splitlines()) == len(
        fabkit_bench.run("shadowtac", rows=["linear"]).rows
    )
