"""What bitwuzla proves about the C text, in IEEE arithmetic and for every pattern of bits."""

from __future__ import annotations

from outcome import Missing, Proof

CURE = "pip install bitwuzla pycparser"
PRECISIONS = ("double", "float")


def _tool() -> str:
    try:
        import bitwuzla
        import pycparser
    except ImportError as error:
        raise Missing(f"{error.name} is not installed; {CURE}") from error
    return f"bitwuzla {bitwuzla.version()}, the C text read by pycparser {pycparser.__version__}"


def guard(quick: bool) -> tuple[str, str, str]:
    """dehyst_accept(x) if and only if x is a number and |x| <= DEHYST_INPUT_LIMIT."""
    used = _tool()
    from bitwuzla import Kind
    from solver.claims import Bench

    for precision in PRECISIONS:
        bench = Bench(precision)
        x = bench.real("x")
        bench.prove([], lambda m, x=x: m.call("dehyst_accept", x),
                    lambda taken, b=bench, x=x: b.theory.term(Kind.EQUAL, taken.term, b.plain(x)))  # fmt: skip
    return used, "all 2^64 doubles, all 2^32 floats", "proved"


def play(quick: bool) -> tuple[str, str, str]:
    """dehyst_play_step: band and idempotence for any x, r >= 0 and z; plays do not see each other, so n = 1 is all."""
    used = _tool()
    from solver.claims import Bench

    for precision in PRECISIONS:
        bench = Bench(precision)
        x, r, z = (bench.real(name) for name in "xrz")
        given = [bench.plain(v) for v in (x, r, z)] + [bench.at_most(bench.theory.value(0), r)]

        def twice(machine, x=x, r=r, z=z):  # type: ignore[no-untyped-def]
            states = [z]
            machine.call("dehyst_play_step", 1, [r], x, states)
            once = list(states)
            machine.call("dehyst_play_step", 1, [r], x, states)
            return once, states

        bench.prove(given, twice, lambda both, b=bench, x=x, r=r: b.band(both[0][0], x, r))
        bench.prove(given, twice, lambda both, b=bench: b.same(*both))
    return (
        used,
        "any x, r >= 0, z; double and float",
        "proved: x - r <= z <= x + r, and the same input twice moves nothing",
    )


def limits(quick: bool) -> tuple[str, str, str]:
    """dehyst_block_step: output within its range whatever the parameters, the state and the arithmetic."""
    used = _tool()
    from solver.claims import Bench, block, copy_of, state

    ways = 0
    for precision in PRECISIONS[1:] if quick else PRECISIONS:
        bench = Bench(precision)
        for on, started, points in ((0, 1, 0),) if quick else ((0, 1, 0), (1, 1, 0)):
            given_block, given_state, x = (
                block(bench, 1, points),
                state(bench, 1, started),
                bench.real("x"),
            )
            low, high = given_block["output_low"], given_block["output_high"]
            given = [bench.at_most(low, high), bench.within(given_state["output"], low, high)]
            ways += bench.prove(
                given,
                lambda m, p=given_block, s=given_state, x=x, on=on: m.call(
                    "dehyst_block_step", p, copy_of(s), x, on
                ),
                lambda y, b=bench, low=low, high=high: b.within(y, low, high),
                anything="+-*/",
            )
    return (
        used,
        f"1 operator, {'float' if quick else 'double and float, on and off'}, {ways} ways",
        ("proved, even if every sum and product were any bits"),
    )


def rejected(quick: bool) -> tuple[str, str, str]:
    """A rejected sample leaves states and output, and only that raises the flag, without a first map."""
    used = _tool()
    from solver.claims import Bench, block, copy_of, state

    ways = 0
    for precision in PRECISIONS[1:] if quick else PRECISIONS:
        bench = Bench(precision)
        given_block, given_state, x = block(bench, 2), state(bench, 2), bench.real("x")

        def stepped(machine, p=given_block, s=given_state, x=x):  # type: ignore[no-untyped-def]
            after = copy_of(s)
            y = machine.call("dehyst_block_step", p, after, x, 1)
            return y, after

        def held(result, b=bench, s=given_state, x=x):  # type: ignore[no-untyped-def]
            y, after = result
            if not after["flags"] & 1:
                return b.plain(x)
            now, before = (
                [*after["model"]["z"], y, after["output"]],
                [*s["model"]["z"], s["output"], s["output"]],
            )
            return b.theory.all([b.theory.negation(b.plain(x)), b.same(now, before)])

        ways += bench.prove([], stepped, held, anything="+-*/")
    return used, f"2 operators, {'float, ' if quick else ''}{ways} ways", "proved"


PROOFS = (
    Proof("guard", "the guard takes x if and only if |x| <= its limit", guard),
    Proof(
        "play",
        "a play keeps to its band and an input twice changes nothing, in IEEE arithmetic",
        play,
    ),
    Proof(
        "limits", "a block's output lies within its range for any parameters and any state", limits
    ),
    Proof(
        "rejected",
        "a rejected sample changes neither states nor output, and no other one is rejected",
        rejected,
    ),
)
