"""gcc's static analyzer over the core, in both precisions."""

from __future__ import annotations

from outcome import CORE, Failed, Proof, said, sources, tool, version

CURE = "on Debian: apt-get install gcc"


def run(quick: bool) -> tuple[str, str, str]:
    """Compile every file with -fanalyzer; a warning is an error."""
    gcc = tool(CURE, "gcc")
    if int(version(gcc, "-dumpfullversion").partition(".")[0]) < 10:
        raise Failed(f"gcc {version(gcc, '-dumpfullversion')} has no analyzer; 10 or newer has")
    options = [
        "-std=c11",
        "-O2",
        "-fanalyzer",
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-Wpedantic",
        "-Werror",
    ]
    for define in ([], ["-DDEHYST_FLOAT"]):
        for source in sources():
            said([gcc, *options, *define, f"-I{CORE}", "-c", source, "-o", "/dev/null"])
    return (
        f"gcc {version(gcc, '-dumpfullversion')} -fanalyzer",
        f"{len(sources())} files, double and float",
        "0 warnings",
    )


PROOFS = (Proof("analyzer", "the analyzer of gcc finds nothing in the core", run),)
