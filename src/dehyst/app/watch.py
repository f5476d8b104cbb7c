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
from dehyst.io.live import Arrival, Names, Skipped, follow, mqtt, opcua
from dehyst.models import load
from dehyst.monitoring.parts import NAMES
from dehyst.monitoring.watch import LEAST, Report, Watch

KEEP = 2.0  # seconds from one saving of the state to the next
SILENCE = 10.0  # seconds without a sample after which it is said what is waited for
SAID = {  # where the answer is another one than before, in front of what was found
    "drifted": "the actuator has changed: ",
    "cannot tell": "whether the actuator has changed cannot be told now: ",
    "unchanged": "the actuator is again as it was identified; ",
    "not comparable": "what comes cannot be compared with the model: ",
}


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
    source, expected = _described(request, names)
    tell(_beginning(request, watch, source))
    signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    status, kept, heard, asked = Status.DONE, time.monotonic(), time.monotonic(), False
    skipped, told = 0, -SILENCE
    try:
        for batch in samples:
            now = time.monotonic()
            if isinstance(batch, Skipped):
                skipped += batch.count
                if now - told > SILENCE:
                    tell(
                        f"{skipped} samples lack a number, the last is {batch.last!r:.80}; they are left out, like a "
                        f"gap in the log. Expected are {expected}."
                    )
                    skipped, told = 0, now
            elif batch is not None:
                heard, asked = now, False
                for report in watch.feed(*batch):
                    _say(report, request.json)
                    if report.alarm:
                        publish(json.dumps(report.as_dict()))
                    status = Status.NO if report.status == "drifted" else Status.DONE
            if now - kept > KEEP:
                watch.save()
                kept = now
            if now - heard > SILENCE and not asked:
                tell(f"nothing has come for {SILENCE:.0f} s; waiting for {expected}")
                asked = True
            if request.until_silent is not None and now - heard > request.until_silent:
                break
    finally:
        watch.save()
    with concluding(status):
        pass


def _described(request: WatchRequest, names: Names) -> tuple[str, str]:
    """Return where samples come from, and what must come there."""
    signals = f"'{names.input}' and '{names.output}'"
    if request.mqtt is not None:
        return request.mqtt, f"messages with the keys {signals} at {request.mqtt}"
    if request.opcua is not None:
        return f"{request.opcua}, asked every {request.sampling:g} s", f"changes of the nodes {signals}"
    there = "" if request.follow is not None and request.follow.exists() else ", which is not there yet"
    return f"{request.follow}{there}", f"lines with the columns {signals} in {request.follow}"


def _beginning(request: WatchRequest, watch: Watch, source: str) -> str:
    """Return what is watched, against what, how often it is judged, where the state is, and how it ends."""
    card = watch.model.card
    if request.state is None:
        state = "not kept; --state FILE keeps it over restarts"
    else:
        known = f", goes on after {watch.samples} kept samples" if watch.samples else ""
        state = f"{request.state}, written every {KEEP:g} s{known}"
    return (
        f"watching {source}\n"
        f"model: {request.model}, {card.input} -> {card.output}\n"
        f"reports: each {request.every} cycles about the last {request.cycles}, the first after {LEAST} whole cycles\n"
        f"state: {state}\n"
        f"stop with Ctrl-C"
    )


def _source(request: WatchRequest, names: Names) -> tuple[Iterator[Arrival], Callable[[str], None]]:
    def nobody(_: str) -> None:
        """Alarms of a file or a server stand on the standard output alone."""

    if request.mqtt is not None:
        return mqtt(request.mqtt, names, ca=request.ca, client=request.client)
    if request.opcua is not None:
        return opcua(request.opcua, names, period=request.sampling, security=request.security), nobody
    assert request.follow is not None
    return follow(request.follow, names), nobody


def _say(report: Report, as_json: bool) -> None:
    """One line on the standard output; where the answer is another one a sentence, and an alarm if there is cause."""
    if as_json:
        line = json.dumps(report.as_dict())
    elif report.alarm:
        found = report.words.partition("; " if report.status == "unchanged" else ": ")[2] or report.words
        word = "ALARM" if report.status in ("drifted", "not comparable") else "NOTE"
        line = f"{report.time:.1f} s  {word}: {SAID[report.status]}{found}"
    else:
        parts = [f"{NAMES[part]} {value:+.3g} {unit}" for part, (value, _, _, unit) in report.changes.items()]
        error = "" if report.error_percent is None else f"error {report.error_percent:.3g} % of range"
        line = f"{report.time:.1f} s  {report.status}  {'; '.join(filter(None, [error, *parts])) or report.words}"
    sys.stdout.write(line + "\n")
    sys.stdout.flush()
