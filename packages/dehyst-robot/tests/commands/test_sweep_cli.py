"""dehyst sweep on the command line: files, messages, picture."""

import functools
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from matplotlib.figure import Figure as Canvas

import dehyst_robot.commands._sweep as command
import sweep_evaluators
from dehyst.app import Status
from dehyst.errors import OutputError
from dehyst.report._svg import draw_panels
from dehyst_robot.commands import SweepRequest
from dehyst_robot.commands._sweep import run_sweep_command
from dehyst_robot.experiments import run_sweep
from dehyst_robot.report import SweepCurve, write_sweep_figure
from dehyst_robot.report._sweep import sweep_figure

TEXT = """
name = "test"
seeds = [1, 2]
trials = ["slow"]
[grid]
"hysteresis.mechanism" = ["dahl", "preisach"]
[[study]]
name = "size"
grid."hysteresis.scale" = [0.5, 2.0]
[[study]]
name = "draws"
draws = 4
random."controller.pole_1_s" = {low = 4.0, high = 16.0}
"""


@pytest.fixture
def request_(tmp_path, monkeypatch):
    """A sweep in an empty folder, run by a stand-in in this process."""
    monkeypatch.chdir(tmp_path)
    Path("my sweep.toml").write_text(TEXT)
    use(monkeypatch, sweep_evaluators.quick)
    return SweepRequest(Path("my sweep.toml"), workers=0)


def use(monkeypatch, evaluate):
    monkeypatch.setattr(command, "run_sweep", functools.partial(run_sweep, evaluate=evaluate))


def test_a_table_and_a_picture_are_written_and_medians_printed(request_, capsys):
    run_sweep_command(request_)
    out, err = capsys.readouterr()
    lines = out.splitlines()
    assert "test: median" in lines[0] and "slow, paper/off" in lines[1]
    assert sum("0.300 (0.300 to 0.300)" in line for line in lines) == 6
    assert "mechanism dahl, scale 0.5" in lines[2] and "pole_1_s drawn" in out
    assert (
        "0 of 24 runs" in err
        and "24 of 24 runs" in err
        and "wrote my sweep.csv (24 rows) and my sweep.svg" in err
    )
    assert sorted(path.name for path in Path().iterdir()) == [
        "my sweep.csv",
        "my sweep.svg",
        "my sweep.toml",
    ]


def test_the_picture_shows_every_run_and_a_line_a_mechanism(request_):
    run_sweep_command(request_)
    text = Path("my sweep.svg").read_text()
    root = ElementTree.fromstring(text)
    assert root[0].text == "dehyst sweep: test"
    words = [element.text or "" for element in root.iter("{http://www.w3.org/2000/svg}text")]
    for word in (
        "slow, paper/off",
        "hysteresis.scale (size)",
        "controller.pole_1_s (draws)",
        "dahl",
        "preisach",
    ):
        assert word in words, word
    assert text.count("<use") >= 24
    assert not [
        word
        for word in ("http://", "https://")
        for line in text.splitlines()
        if f'href="{word}' in line
    ]


def test_no_run_lies_outside_its_panel_and_panels_of_a_figure_share_their_range():
    canvas = Canvas()
    curves = [
        SweepCurve("a", x, "ratio", [1.0, 2.0], [0.2, top], [""] * 2)
        for x, top in (("x", 3.0), ("y", 0.5))
    ]
    draw_panels(canvas, sweep_figure("s", curves).panels, 1)
    for axes in canvas.axes:
        low, high = axes.get_ylim()
        assert low == 0.0 and 3.0 < high < 3.5


def test_a_group_has_one_colour_in_all_panels_and_is_named_once():
    groups = ["dahl", "preisach"], ["preisach", "preisach"]
    curves = [
        SweepCurve("a", x, "ratio", [1.0, 2.0], [0.2, 0.4], each)
        for x, each in zip("xy", groups, strict=True)
    ]
    canvas, figure = Canvas(), sweep_figure("s", curves)
    draw_panels(canvas, figure.panels, 1)
    colours = [
        {line.get_color() for line in axes.lines if line.get_label() == "preisach"}
        for axes in canvas.axes
    ]
    assert colours[0] == colours[1] and len(colours[0]) == 1
    assert [panel.legend for panel in figure.panels] == [True, False]


def test_a_png_is_a_png_and_another_ending_is_refused(request_, tmp_path):
    run_sweep_command(SweepRequest(request_.sweep, figure=Path("a.png"), workers=0))
    assert Path("a.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(OutputError, match=r"\.svg or \.png"):
        run_sweep_command(SweepRequest(request_.sweep, figure=Path("a.pdf"), workers=0))


@pytest.mark.slow
def test_figures_over_texts_and_without_any_value_can_be_drawn(tmp_path):
    curves = [
        SweepCurve(
            "a",
            "hysteresis.mechanism",
            "ratio",
            ["dahl", "none"] * 2,
            [1.0, None, 0.5, None],
            ["", "", "", ""],
        ),
        SweepCurve("b", "load_Nm", "ratio", [1.0, 2.0], [None, float("nan")], ["x", "y"]),
        SweepCurve(
            "b", "load_Nm", "$p_1$ & <i>", [1.0, True], [1.0, 2.0], ["_x", "_x"], scattered=True
        ),
    ]
    for name in ("a.svg", "a.png"):
        assert write_sweep_figure(tmp_path / name, "a & b", curves).stat().st_size > 1000
        assert write_sweep_figure(tmp_path / name, "nothing", []).exists()


def test_a_picture_of_ones_own_is_not_lost_but_an_earlier_one_of_the_sweep_is_renewed(request_):
    figure = Path("my sweep.svg")
    figure.write_text("<svg>mine</svg>")
    with pytest.raises(OutputError, match="--overwrite"):
        run_sweep_command(request_)
    assert figure.read_text() == "<svg>mine</svg>" and not Path("my sweep.csv").exists()
    figure.unlink()
    run_sweep_command(request_)
    Path("my sweep.csv").unlink()
    run_sweep_command(request_)


def test_failed_runs_are_counted_with_the_line_that_tries_them_again(request_, capsys, monkeypatch):
    use(monkeypatch, sweep_evaluators.fails_at_scale_2)
    with pytest.raises(SystemExit) as ended:
        run_sweep_command(request_)
    out, err = capsys.readouterr()
    assert ended.value.code == Status.NO
    assert "4 of 24 runs failed" in err and "ZeroDivisionError: no such plant" in err
    assert 'dehyst sweep "my sweep.toml" --workers 0 --retry' in err
    assert "2 (2 failed)" in out
    use(monkeypatch, sweep_evaluators.fails_at_scale_2)
    with pytest.raises(SystemExit):
        run_sweep_command(SweepRequest(request_.sweep, workers=0, retry=True))
    assert "20 of 24 runs, 20 of them from the table" in capsys.readouterr().err


def test_ctrl_c_says_the_line_to_go_on(request_, capsys, monkeypatch):
    class Stopped(command._ProgressDisplay):
        def __call__(self, finished, failed, total, resumed):
            super().__call__(finished, failed, total, resumed)
            if finished == 5:
                raise KeyboardInterrupt

    with monkeypatch.context() as stopping:
        stopping.setattr(command, "_ProgressDisplay", Stopped)
        with pytest.raises(SystemExit) as ended:
            run_sweep_command(request_)
    assert ended.value.code == 130
    assert 'To go on: dehyst sweep "my sweep.toml" --workers 0\n' in capsys.readouterr().err
    run_sweep_command(request_)
    assert "5 of 24 runs, 5 of them from the table" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [["nowhere.toml"], ["bad.toml"], ["good.toml", "--out", "a.txt"], ["good.toml", "--out", "no/a.csv"],
     ["good.toml", "--workers", "-2"], ["good.toml", "--figure", "a.gif"]],
)  # fmt: skip
def test_bad_input_gives_a_message_and_no_traceback(tmp_path, monkeypatch, capsys, arguments):
    from dehyst import cli

    monkeypatch.chdir(tmp_path)
    Path("good.toml").write_text(TEXT)
    Path("bad.toml").write_text(TEXT.replace("pole_1_s", "pole"))
    monkeypatch.setattr(sys, "argv", ["dehyst", "sweep", *arguments])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    err = capsys.readouterr().err
    assert ended.value.code == 2 and "Error: " in err and "Traceback" not in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.toml", "good.toml"]


@pytest.mark.slow
def test_a_terminal_gets_a_bar_with_rate_and_time_left():
    pty = pytest.importorskip("pty")
    program = (
        "from dehyst_robot.commands._sweep import _shown_progress\nimport time\n"
        "with _shown_progress() as tell:\n"
        "    for done in range(4, 31):\n        tell(done, done // 20, 30, 4)\n        time.sleep(0.02)\n"
    )
    here, there = pty.openpty()
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "TERM": "xterm",
        "COLUMNS": "100",
    }
    with subprocess.Popen(
        [sys.executable, "-c", program], stderr=there, env=environment
    ) as process:
        os.close(there)
        told = b""
        try:
            while chunk := os.read(here, 65536):
                told += chunk
        except OSError:  # the other side was closed
            pass
    text = told.decode()
    assert (
        process.returncode == 0 and "of 30 runs" in text and "runs/s" in text and "1 failed" in text
    )
    assert "left" in text and "0:0" in text
