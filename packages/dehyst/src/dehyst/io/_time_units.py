"""Units of a time column as loggers write them: how many seconds one of them is, and what a name tells of its unit."""

from __future__ import annotations

import math
import re

from dehyst.units import TABLE, words

DAY = 86400.0
_SPELLINGS = {
    1.0: "s ss sec secs second seconds sek sekunde sekunden seg segundo segundos seconde secondes secondi",
    1e-3: "ms msec msecs msek millis millisec millisecond milliseconds millisekunde millisekunden milisegundos",
    1e-6: "us usec usecs micros microsec microsecond microseconds mikrosekunde mikrosekunden",
    1e-9: "ns nsec nsecs nanos nanosec nanosecond nanoseconds nanosekunde nanosekunden",
    1e-12: "ps psec picosecond picoseconds pikosekunde pikosekunden",
    1e-15: "fs fsec femtosecond femtoseconds femtosekunde femtosekunden",
    1e-2: "cs csec centisec centisecond centiseconds hundredths",
    1e-1: "ds dsec decisec decisecond deciseconds tenths",
    1e3: "ks kilosecond kiloseconds",
    60.0: "min mins minute minutes minuten minuto minutos minuti mn",
    3600.0: "h hh hr hrs hour hours std stunde stunden heure heures hora horas ora ore",
    DAY: "d day days tag tage tagen jour jours día días dia dias giorno giorni dag dagen",
    604800.0: "wk wks week weeks woche wochen semaine semaines semana semanas",
}
_SECONDS = {word: factor for factor, spelled in _SPELLINGS.items() for word in spelled.split()}
# What a clock without a unit of time counts, where its name ends in such a word.
COUNTED = frozenset(
    words(
        "tick ticks sample samples cycle cycles jiffy jiffies count counts counter frame frames step steps takt takte "
        "clk pulse pulses index scan scans"
    )
)
# In brackets behind a time: which clock it is, not what it counts in.
_QUALIFIERS = frozenset(
    words(
        "utc gmt local lokal relative rel absolute abs elapsed raw unix epoch posix header system ros sim plc"
    )
)
_NUMBER = r"(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?"
_POWER = r"10(?:\^|\*\*)([+-]?\d+)"
_MULTIPLE = re.compile(
    rf"(?:[x×*]\s*)?(?:{_POWER}|({_NUMBER})(?:\s*/\s*({_NUMBER}))?)\s*[x×*·-]?\s*(.*)"
)
_BRACKETS = re.compile(r".*?\S?\s*[\[({<]([^\[\](){}<>]*)[\])}>][\s\d_]*")
_BOUNDARY = re.compile(r"[\s_/:,;|.-]+|(?<=[a-z])(?=[A-Z])")


def _value(text: str | None) -> float:
    return float(text.replace(",", ".")) if text else 1.0


def seconds_of(unit: str) -> float | None:
    """Seconds of a unit of time, None if it is none.

    Examples
    --------
    >>> [seconds_of(unit) for unit in ("ms", "Tage", "0.1 s", "1/10 s", "10 ms", "s/10", "ticks", "Ms")]
    [0.001, 86400.0, 0.1, 0.1, 0.01, 0.1, None, None]
    """
    text = re.sub(r"\s+since\b.*", "", unit.strip()).strip().replace("µ", "u").replace("μ", "u")
    if text in TABLE["time"]:
        return TABLE["time"][text]
    part = re.fullmatch(rf"(.*\S)\s*/\s*({_NUMBER})", text)
    if part and part[1][-1].isalpha():
        whole, divisor = seconds_of(part[1]), _value(part[2])
        return whole / divisor if whole and divisor else None
    many = _MULTIPLE.fullmatch(text)
    if many and many[4]:
        single = seconds_of(many[4])
        if single is None:
            return None
        times = 10.0 ** int(many[1][:4]) if many[1] else _value(many[2])
        divisor = _value(many[3])
        factor = times * single / divisor if divisor else 0.0
        return factor if 0 < factor < math.inf else None
    # A megasecond to the letter and a millisecond to most who write it: a thousand million times apart.
    return None if text == "Ms" else _SECONDS.get(text.lower().rstrip("."))


def unit_in_name(name: str) -> str:
    """Unit that the name of a time column ends in, known or not, "" if it names none.

    Examples
    --------
    >>> [unit_in_name(name) for name in ("Zeit in Tagen", "elapsedMs", "time_ticks", "t {10us}", "time_2")]
    ['Tagen', 'ms', 'ticks', '10us', '']
    """
    bracket = _BRACKETS.fullmatch(name.strip())
    if bracket:
        return of_clock(bracket[1])
    for place in _BOUNDARY.finditer(name):
        tail = name[place.end() :].strip()
        if tail == "Ms":  # capital as words of names are
            return "ms"
        if place.start() > 0 and (tail.lower() in COUNTED or seconds_of(tail) is not None):
            return tail
    return ""


def of_clock(text: str) -> str:
    """Return what a clock is said to count in, "" where only the clock is meant.

    Examples
    --------
    >>> of_clock("ticks"), of_clock("UTC+01:00"), of_clock("-")
    ('ticks', '', '')
    """
    first = re.match(r"[^\W\d_]+", text.strip())
    nothing = not re.search(r"\w", text) or text.strip() in {"1", "none", "None"}
    return "" if nothing or (first and first[0].lower() in _QUALIFIERS) else text.strip()
