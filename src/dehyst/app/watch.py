"""dehyst watch: follows an actuator while it runs, and says when it is no longer the one that was identified."""

from __future__ import annotations

import json
import signal
import sys
import time
from collections.abc import Callable, Iterator

from dehyst.app.ending import Status, concluding
from dehyst.app.requests import WatchRequest
from dehyst.app.terminal import tell
from dehyst.errors import ParameterError
from dehyst.io.live import Batch, Names, follow, mqtt, opcua
from dehyst.models import load
from dehyst.monitoring.watch import Report, Watch

KEEP = 2.0  # seconds from one saving of the state to the next


def run_watch(request: WatchRequest) -> None:
    """Feed what comes, print what is found, keep the state; end by Ctrl-C, SIGTERM, or after a silence if asked to."""
    given = [source for source in (request.follow, request.mqtt, request.opcua) if source is not None]
    if len(given) != 1:
        raise ParameterError(
            f"{len(given)} sources are named. Name one: --follow FILE, --mqtt mqtt://HOST/TOPIC or --opcua "
            f"opc.tcp://HOST:4840."
        )
    model = load(request.model)
    watch = Watch(
        model, cycles=request.cycles, every=request.every, state=request.state,
        false_alarm=request.false_alarm, least=request.least, ignore=request.ignore,
    )  # fmt: skip
    names = Names(request.input or model.card.input.name, request.output or model.card.output.name, request.time)
    samples, publish = _source(request, names)
    signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    status, kept, heard = Status.DONE, time.monotonic(), time.monotonic()
    try:
        for batch in samples:
            now = time.monotonic()
            if batch is not None:
                heard = now
                for report in watch.feed(*batch):
                    _say(report, request.json)
                    if report.alarm:
                        publish(json.dumps(report.as_dict()))
                    status = Status.NO if report.status == "drifted" else Status.DONE
            if now - kept > KEEP:
                watch.save()
                kept = now
            if request.until_silent is not None and now - heard > request.until_silent:
                break
    finally:
        watch.save()
    with concluding(status):
        pass


def _source(request: WatchRequest, names: Names) -> tuple[Iterator[Batch | None], Callable[[str], None]]:
    def nobody(_: str) -> None:
        """Alarms of a file or a server stand on the standard output alone."""

    if request.mqtt is not None:
        return mqtt(request.mqtt, names, ca=request.ca, client=request.client)
    if request.opcua is not None:
        return opcua(request.opcua, names, period=request.sampling, security=request.security), nobody
    assert request.follow is not None
    if not request.follow.exists():
        tell(f"waiting for {request.follow} ...")
    return follow(request.follow, names), nobody


def _say(report: Report, as_json: bool) -> None:
    """One line on the standard output."""
    if as_json:
        line = json.dumps(report.as_dict())
    else:
        parts = [f"{part} {value:+.3g} {unit}" for part, (value, _, _, unit) in report.changes.items()]
        error = "" if report.error_percent is None else f"error {report.error_percent:.3g} % of range"
        mark = "ALARM " if report.alarm else ""
        line = f"{report.time:.1f} s  {mark}{report.status}  {'; '.join(filter(None, [error, *parts])) or report.words}"
    sys.stdout.write(line + "\n")
    sys.stdout.flush()
