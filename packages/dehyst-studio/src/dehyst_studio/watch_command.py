"""dehyst watch: follows an actuator while it runs, and says when it is no longer the one that was identified."""

from __future__ import annotations

import json
import signal
import sys
import time
from collections.abc import Callable, Iterator

from dehyst.app import Status, concluding, tell
from dehyst.app import kit as app_kit
from dehyst.errors import ParameterError
from dehyst.models import load
from dehyst.monitoring import NAMES
from dehyst_studio.live import Arrival, Names, Notice, Skipped, follow_live
from dehyst_studio.mqtt import mqtt
from dehyst_studio.opcua import opcua
from dehyst_studio.requests import WatchRequest
from dehyst_studio.watch import LEAST, Report, Watch

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
    sources = [
        source for source in (request.follow, request.mqtt, request.opcua) if source is not None
    ]
    if len(sources) != 1:
        raise ParameterError(
            f"{len(sources)} sources are named. Name one: --follow FILE, --mqtt mqtt://HOST/TOPIC or --opcua "
            f"opc.tcp://HOST:4840."
        )
    model = load(request.model)
    watch = Watch(
        model, cycles=request.cycles, every=request.every, state=request.state,
        false_alarm=request.false_alarm, least=request.least, ignore=request.ignore,
    )  # fmt: skip
    names = Names(
        request.input or model.card.input.name, request.output or model.card.output.name, request.time,
        request.time_unit, (model.card.input, model.card.output),
    )  # fmt: skip
    samples, publish = _source(request, names)
    source, expected = _described(request, names)
    tell(_beginning(request, watch, source))
    signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    answer, samples_read = "", 0
    last_saving = last_sample = time.monotonic()
    is_asked = False
    left_out = _LeftOut(expected)
    try:
        for arrival in samples:
            now = time.monotonic()
            if isinstance(arrival, Notice):
                tell(arrival.text)
            elif isinstance(arrival, Skipped):
                left_out.add(arrival)
            elif arrival is not None:
                last_sample, is_asked = now, False
                samples_read += len(arrival[0])
                for report in watch.feed(*arrival):
                    _say(report, request.json)
                    if report.alarm:
                        publish(json.dumps(report.as_dict()))
                    answer = report.status
            left_out.tell(now, watch.strange)
            if now - last_saving > KEEP:
                watch.save()
                last_saving = now
            if now - last_sample > SILENCE and not is_asked:
                tell(f"nothing has come for {SILENCE:.0f} s; waiting for {expected}")
                is_asked = True
            if request.until_silent is not None and now - last_sample > request.until_silent:
                break
    finally:
        watch.save()
    if not answer:
        tell(
            f"no report: {samples_read} samples came, {left_out.total + watch.strange} were left out, and a report "
            f"needs {LEAST} whole cycles. Nothing was judged."
        )
    with concluding(app_kit.ENDS[answer][0] if answer else Status.NOT_COMPARABLE):
        pass


class _LeftOut:
    """Counts what holds no sample, and says so now and then."""

    def __init__(self, expected: str) -> None:
        self.total = 0
        self._expected, self._said, self._strange, self._when = expected, 0, 0, -SILENCE
        self._last = Skipped(0, "")

    def add(self, skipped: Skipped) -> None:
        """Count what was skipped."""
        self.total += skipped.count
        self._last = skipped

    def tell(self, now: float, strange: int) -> None:
        """Say what is new, not more often than every 10 s; `strange` samples stand apart from those around them."""
        if now - self._when <= SILENCE or (self.total, strange) == (self._said, self._strange):
            return
        if self.total > self._said:
            why = f" ({self._last.why})" if self._last.why else ""
            tell(
                f"{self.total - self._said} samples lack a number, the last is {self._last.last!r:.80}{why}; they are "
                f"left out, like a gap in the log. Expected are {self._expected}."
            )
        if strange > self._strange:
            tell(
                f"{strange - self._strange} samples stand apart from those before and after them, back in time or far "
                f"beyond the range of the model; they are left out. Look at what sends them."
            )
        self._said, self._strange, self._when = self.total, strange, now


def _described(request: WatchRequest, names: Names) -> tuple[str, str]:
    """Return where samples come from, and what must come there."""
    signals = f"'{names.input}' and '{names.output}'"
    if request.mqtt is not None:
        return request.mqtt, f"messages with the keys {signals} at {request.mqtt}"
    if request.opcua is not None:
        return (
            f"{request.opcua}, asked every {request.sampling:g} s",
            f"changes of the nodes {signals}",
        )
    absence = ""
    if request.follow is None or not request.follow.exists():
        absence = ", which is not there yet"
    return f"{request.follow}{absence}", f"lines with the columns {signals} in {request.follow}"


def _beginning(request: WatchRequest, watch: Watch, source: str) -> str:
    """Return what is watched, against what, how often it is judged, where the state is, and how it ends."""
    card = watch.model.card
    if request.state is None:
        state = "not kept; --state FILE keeps it over restarts"
    else:
        state = f"{request.state}, written every {KEEP:g} s"
        if watch.samples:
            state += f", goes on after {watch.samples} kept samples"
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
        return opcua(
            request.opcua, names, period=request.sampling, security=request.security
        ), nobody
    assert request.follow is not None
    return follow_live(request.follow, names), nobody


def _say(report: Report, as_json: bool) -> None:
    """One line on the standard output; where the answer is another one a sentence, and an alarm if there is cause."""
    if as_json:
        line = json.dumps(report.as_dict())
    elif report.alarm:
        # The verdict begins with a clause that the alarm says in its own words.
        separator = ": "
        if report.status == "unchanged":
            separator = "; "
        detail = report.words.partition(separator)[2] or report.words
        word = "NOTE"
        if report.status in ("drifted", "not comparable"):
            word = "ALARM"
        line = f"{report.time:.1f} s  {word}: {SAID[report.status]}{detail}"
    else:
        parts = []
        if report.error_percent is not None:
            parts.append(f"error {report.error_percent:.3g} % of range")
        for part, (value, _, _, unit) in report.changes.items():
            parts.append(f"{NAMES[part]} {value:+.3g} {unit}")
        line = f"{report.time:.1f} s  {report.status}  {'; '.join(parts) or report.words}"
    sys.stdout.write(line + "\n")
    sys.stdout.flush()
