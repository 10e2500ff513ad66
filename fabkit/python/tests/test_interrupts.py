"""Ctrl-C stops long calls of the package and its command."""

import os
import signal
import subprocess
import sys
import time

import pytest

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals are sent as on POSIX")

LONG = """
import signal, sys, threading, time
import fabkit
# Shells start what runs behind them deaf to Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
sensor = fabkit.load("uvdtact")
start = time.monotonic()
threading.Timer(0.5, lambda: signal.raise_signal(signal.SIGINT)).start()
try:
    {call}
    print("finished", flush=True)
except KeyboardInterrupt:
    print("interrupted", time.monotonic() - start, flush=True)
sys.exit(7)
"""


@pytest.mark.parametrize(
    "call", ["sensor.check()", "sensor.export('{folder}', tolerance_mm=5e-4, progress=False)"]
)
def test_long_calls_stop(call, tmp_path):
    folder = tmp_path / "out"
    script = LONG.format(call=call.format(folder=folder))
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    # The interpreter continues and exits with the script's code.
    assert done.returncode == 7, done.stderr
    word, seconds = done.stdout.split()
    assert word == "interrupted"
    # Interrupts are checked every 25 ms; the rest is for busy machines. The work takes seconds.
    assert float(seconds) < 0.5 + 1.0
    assert not folder.exists()


def test_a_progress_that_raises_stops_the_work(rtac0, tmp_path):
    def progress(done, count):
        raise RuntimeError(f"{done} of {count}")

    with pytest.raises(RuntimeError, match="0 of 13"):
        rtac0.export(tmp_path / "out", formats=["stl"], tolerance_mm=5e-4, progress=progress)
    assert not (tmp_path / "out").exists()


def test_progress_is_reported(rtac0, tmp_path):
    told = []
    rtac0.export(tmp_path, formats=["stl"], progress=lambda *at: told.append(at))
    assert told[-1] == (13, 13)
    assert told == sorted(told)


def test_interrupted_command_exits_cleanly():
    # Runs `fabkit check uvdtact`, and prints when Python has started.
    script = "import sys; from fabkit.__main__ import main; print('ready', flush=True); main()"
    line = [sys.executable, "-c", script, "check", "uvdtact"]
    process = subprocess.Popen(line, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    _, text = process.communicate(timeout=30)
    assert (process.returncode, text) == (130, "error: interrupted\n")


def test_the_command_of_the_package_works(command):
    import fabkit

    assert command("--version") == f"fabkit {fabkit.__version__}\n"
    done = command("lst", check=False)
    assert done.returncode == 2
    assert "a similar subcommand exists: 'list'" in done.stderr


def test_progress_is_a_bar_where_there_is_tqdm(rtac0, tmp_path, capsys):
    pytest.importorskip("tqdm")
    rtac0.export(tmp_path, formats=["stl"], progress=True)
    assert "export rtac0" in capsys.readouterr().err
    # No bar on a file.
    rtac0.export(tmp_path, formats=["stl"])
    assert capsys.readouterr().err == ""
