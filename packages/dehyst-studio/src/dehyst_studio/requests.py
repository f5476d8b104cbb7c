"""Arguments and options of the commands of the studio; see `dehyst.app.requests`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from dehyst.app import argument, option
from dehyst.app import kit as app_kit


@dataclass(frozen=True, eq=False)
class WatchRequest:
    """Watch an actuator while it runs: drift, gain and loop width over its last cycles, alarms when they change."""

    model: Path = argument(app_kit.MODEL)
    follow: Path | None = option("Text log that grows.")
    mqtt: str | None = option(
        "Topic of a broker: mqtt://HOST/TOPIC or mqtts://USER@HOST/TOPIC; password: DEHYST_PASSWORD."
    )
    opcua: str | None = option(
        "Server: opc.tcp://[USER@]HOST:PORT; --input and --output are node ids."
    )
    input: str | None = option(app_kit.INPUT)
    output: str | None = option(app_kit.OUTPUT)
    time: str | None = option()
    time_unit: str | None = option()
    cycles: int = option("Last cycles that a report is about.", 24)
    every: int = option("Cycles from one report to the next.", 6)
    false_alarm: float = option("Probability of a false alarm in one report.", 0.001)
    least: float | None = option("Smallest change worth reporting, rms in percent of range.")
    ignore: tuple[str, ...] = option("Part that does not count, e.g. offset; repeat for more.", ())
    state: Path | None = option("File that keeps cycles and status over restarts.")
    ca: Path | None = option("Certificate of the authority of an mqtts broker.")
    client: str = option("Name of the session at the broker, one for each watch.", "dehyst")
    sampling: float = option("Sampling interval asked of an OPC UA server [s].", 0.01)
    security: str = option("OPC UA: Policy,Mode,certificate,key.", "")
    until_silent: float | None = option("End when nothing came for so long [s].")
    json: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class PageRequest:
    """Write the page that fits a log in a browser: one file, nothing to install, nothing uploaded."""

    out: Path = argument("HTML file to write.", Path("dehyst.html"), metavar="[OUT.html]")
    overwrite: bool = option(default=False)


@dataclass(frozen=True, eq=False)
class StudioRequest:
    """Open dehyst in a browser: logs dropped or named, all commands behind the page; nothing leaves this machine."""

    log: Path | None = argument("Log to begin with.", None, metavar="[LOG]")
    port: int = option("Port to listen on, of this machine alone; a free one without it.", 0)
    browser: bool = option("Whether a browser is opened.", True, flag="--browser/--no-browser")
    idle: float = option("Minutes without an open page until it ends; 0: never.", 5.0)
