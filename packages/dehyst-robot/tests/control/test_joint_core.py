"""The joint controller as C: other compilers' bits, float, a guard under fast-math; and its state as a thing apart."""

import re
import struct
import subprocess
import zlib
from dataclasses import replace

import numpy as np
import pytest

from dehyst import PrandtlIshlinskii
from dehyst.errors import ParameterError
from dehyst_robot.control import FLAGS, JointController, JointControllerParameters, JointReference
from joint_oracles import PERIOD, reference_along
from test_core_build import CORE, SOURCES, STRICT, run, tool

# Readings of the test do not answer the valves: no prediction of theirs is right.
JOINT = JointControllerParameters(frozen_samples=0, angle_jump=0.0, pressure_jump=0.0)
MODEL = PrandtlIshlinskii([0.0, 0.3, 0.8, 1.5], [0.6, 0.2, 0.1, 0.05]).inverse()
SAMPLES = 1200
OUTPUTS = [
    "valve[0]",
    "valve[1]",
    "desired[0]",
    "desired[1]",
    "pressure_difference",
    "torque",
    "integrator",
]
OUTPUTS += ["compensation", "angle", "velocity", "load"]


def signals(dirty=False):
    """Return readings (T, 3), references (T, 7) and switches (T,)."""
    t = PERIOD * np.arange(SAMPLES)
    rng = np.random.default_rng(2)
    reference = reference_along(3 * t, 0.3)
    reference[:, 3] = 4 * np.sin(8 * t)
    readings = np.column_stack(
        [0.9 * reference[:, 0], 3e5 + 4e4 * np.sin(5 * t), 3e5 - 4e4 * np.sin(5 * t)]
    )
    readings[:, 1:] += 250 * rng.normal(size=(SAMPLES, 2))
    switches = np.repeat([0, 1, 7, 5, 7, 0], SAMPLES // 6)
    if dirty:
        bad = np.array([np.nan, -np.nan, np.inf, -np.inf, 1e300])
        for column, start in enumerate((300, 400, 500)):
            readings[start : start + 20, column] = np.tile(bad, 4)
        reference[600:620, 2] = np.tile(bad, 4)
    return readings, reference, switches


def extension(dirty=False):
    readings, reference, switches = signals(dirty)
    controller = JointController(JOINT, MODEL)
    controller.reset(*readings[0])
    return controller.run(*readings.T, reference, switches)


def program(joint, model):
    """Return a C program that knows the parameters in hex floats and prints its outputs in bits."""
    lines = []
    for name, value in joint.as_dict().items():
        if name == "pneumatics":
            lines += [f"joint.pneumatics.{k} = (dehyst_real){v.hex()};" for k, v in value.items()]
        elif name == "volume":
            lines += [
                f"joint.volume[{i}][{j}] = (dehyst_real){x.hex()};"
                for i in (0, 1)
                for j, x in enumerate(value[i])
            ]
        elif isinstance(value, tuple):
            lines += [f"joint.{name}[{j}] = (dehyst_real){x.hex()};" for j, x in enumerate(value)]
        else:
            lines.append(
                f"joint.{name} = "
                + (f"{value};" if isinstance(value, int) else f"(dehyst_real){value.hex()};")
            )
    thresholds, weights, center, offset, *_, state = model.stepper().parameters
    for name, values in (("r", thresholds), ("w", weights), ("start", state)):
        lines += [f"{name}[{j}] = (dehyst_real){float(x).hex()};" for j, x in enumerate(values)]
    lines.append(f"model.hysteresis.n = {len(thresholds)};")
    lines.append(f"model.hysteresis.center = (dehyst_real){center.hex()};")
    lines.append(f"model.hysteresis.offset = (dehyst_real){offset.hex()};")
    prints = " ".join(f"show((double)out.{name});" for name in OUTPUTS)
    return PROGRAM.replace("PARAMETERS", "\n    ".join(lines)).replace("PRINTS", prints)


PROGRAM = r"""
#include <stdio.h>
#include <string.h>
#include "dehyst.h"
static void show(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, 8);
    printf("%llx ", (unsigned long long)bits);
}
static dehyst_real real(double x)
{
    return (dehyst_real)x;
}
int main(void)
{
    static dehyst_real r[100], w[100], start[100], z[100];
    static dehyst_joint joint;
    static dehyst_joint_state state;
    static dehyst_model model;
    dehyst_joint_sensors sensors;
    dehyst_joint_reference reference;
    dehyst_joint_output out;
    double row[11];
    int begun = 0;
    PARAMETERS
    model.hysteresis.threshold = r;
    static dehyst_real slope[100], loading[100];
    dehyst_pi_tables(model.hysteresis.n, r, w, slope, loading);
    model.hysteresis.slope = slope;
    model.hysteresis.loading = loading;
    joint.compensator = &model;
    state.compensator.z = z;
    while (fread(row, 8, 11, stdin) == 11) {
        sensors.angle = real(row[0]);
        sensors.pressure[0] = real(row[1]);
        sensors.pressure[1] = real(row[2]);
        reference.angle = real(row[3]);
        reference.velocity = real(row[4]);
        reference.acceleration = real(row[5]);
        reference.load = real(row[6]);
        reference.mean_pressure = real(row[7]);
        reference.pressure_difference = real(row[8]);
        reference.extra = real(row[9]);
        if (!begun) dehyst_joint_reset(&joint, &state, &sensors, start);
        begun = 1;
        dehyst_joint_step(&joint, &state, &sensors, &reference, (uint32_t)row[10], &out);
        PRINTS
        printf("%u\n", (unsigned)out.flags);
    }
    return 0;
}
"""


def compiled(flags, tmp_path, dirty=False):
    """Compile the core with that program and run it: outputs (T, 11), flags (T,)."""
    main, binary = tmp_path / "main.c", tmp_path / "main"
    main.write_text(program(JOINT, MODEL), encoding="utf-8")
    run(tool("gcc", "clang", "cc"), *flags, f"-I{CORE}", main, *SOURCES, "-o", binary)
    readings, reference, switches = signals(dirty)
    rows = np.column_stack([readings, reference, switches]).astype("<f8")
    done = subprocess.run([binary], input=rows.tobytes(), capture_output=True, timeout=600)
    assert done.returncode == 0
    lines = [line.split() for line in done.stdout.decode().splitlines()]
    values = [
        [struct.unpack("<d", int(x, 16).to_bytes(8, "little"))[0] for x in line[:-1]]
        for line in lines
    ]
    return np.array(values), np.array([int(line[-1]) for line in lines])


def table(out):
    names = ["valve_1", "valve_2", "desired_1", "desired_2", *OUTPUTS[4:]]
    return np.column_stack([getattr(out, name) for name in names])


@pytest.mark.slow
@pytest.mark.parametrize(
    "flags", [["-std=c11", "-O0"], ["-std=c99", "-O2", "-ffp-contract=off"]], ids=" ".join
)
def test_another_build_gives_the_bits_of_the_extension(flags, tmp_path):
    values, raised = compiled(flags, tmp_path)
    expected = extension()
    assert np.ascontiguousarray(table(expected)).tobytes() == values.tobytes()
    assert np.array_equal(raised, expected.flags)
    assert np.ptp(expected.compensation) > 1e3


@pytest.mark.slow
def test_the_guards_survive_fast_math(tmp_path):
    values, raised = compiled(["-std=c11", "-Ofast"], tmp_path, dirty=True)
    expected = extension(dirty=True)
    assert np.all(np.isfinite(values))
    faults = sum(
        FLAGS[n] for n in ("angle-fault", "pressure-fault-1", "pressure-fault-2", "reference-fault")
    )
    assert np.array_equal(raised & faults, expected.flags & faults)
    for name, start in zip(
        ("angle-fault", "pressure-fault-1", "pressure-fault-2", "reference-fault"),
        (300, 400, 500, 600),
        strict=True,
    ):
        assert np.array_equal(np.flatnonzero(raised & FLAGS[name]), np.arange(start, start + 20))
    np.testing.assert_allclose(values, table(expected), rtol=1e-6, atol=1e-6)


@pytest.mark.slow
def test_the_float_build_is_clean_and_close(tmp_path):
    flags = ["-std=c11", "-O2", "-DDEHYST_FLOAT"]
    values, raised = compiled(flags, tmp_path)
    expected = table(extension())
    size = np.max(np.abs(expected), axis=0)
    error = np.max(np.abs(values - expected), axis=0) / size
    assert dict(zip(OUTPUTS, error, strict=True))["pressure_difference"] < 2e-3
    assert np.all(error[2:10] < 5e-3), dict(zip(OUTPUTS, error, strict=True))
    assert not (raised & FLAGS["fault-ever"]).any()


@pytest.mark.slow
@pytest.mark.parametrize("precision", [[], ["-DDEHYST_FLOAT"]], ids=["double", "float"])
def test_the_core_is_clean_c99_too(precision, tmp_path):
    for source in SOURCES:
        run(
            tool("gcc", "clang"),
            "-std=c99",
            *STRICT,
            *precision,
            "-c",
            source,
            "-o",
            tmp_path / "out.o",
        )


def test_two_controllers_do_not_know_of_each_other():
    readings, reference, switches = signals()
    alone = table(extension())
    pair = [JointController(JOINT, MODEL), JointController(JOINT, MODEL)]
    for controller in pair:
        controller.reset(*readings[0])
    rows = [[], []]
    for k in range(300):
        for controller, kept, row in zip(
            pair, rows, (k, 0), strict=True
        ):  # the second one lives another life
            kept.append(
                table(
                    controller.run(
                        *readings[row : row + 1].T, reference[row : row + 1], switches[[row]]
                    )
                )
            )
    assert np.concatenate(rows[0]).tobytes() == np.ascontiguousarray(alone[:300]).tobytes()
    assert np.concatenate(rows[1])[-1].tobytes() != alone[299].tobytes()


def halves():
    readings, reference, switches = signals(dirty=True)
    first, second = slice(0, 500), slice(500, SAMPLES)
    return [(*readings[part].T, reference[part], switches[part]) for part in (first, second)]


@pytest.mark.parametrize("model", [MODEL, None], ids=["compensator", "none"])
def test_a_restored_controller_goes_on_bit_for_bit(model):
    first, second = halves()
    controller, other = JointController(JOINT, model), JointController(JOINT, model)
    controller.reset(*(x[0] for x in first[:3]))
    controller.run(*first)
    image = controller.save()
    other.restore(image)
    assert other.save() == image
    answer, again = controller.run(*second), other.run(*second)
    assert table(answer).tobytes() == table(again).tobytes()
    assert np.array_equal(answer.flags, again.flags)


def signed(image):
    """Return an image with the checksum that belongs to it, by zlib."""
    return image[:-4] + zlib.crc32(image[:-4]).to_bytes(4, "little")


def with_word(image, index, value):
    return signed(image[: 4 * index] + value.to_bytes(4, "little") + image[4 * index + 4 :])


def test_images_that_do_not_belong_are_refused_by_name():
    controller = JointController(JOINT, MODEL)
    image = controller.save()
    assert signed(image) == image
    flipped = bytearray(image)
    flipped[len(image) // 2] ^= 1
    others = [
        JointController(replace(JOINT, pole=7.0), MODEL),
        JointController(JOINT),
        JointController(JOINT, MODEL),
    ]
    others[2].exchange(MODEL, shear=5.0)
    other_parameters, no_compensator, exchanged = (other.save() for other in others)
    bad = {
        "size": [b"", image[:-1], image[:-4], image + b"\0", image + b"\0\0\0\0", no_compensator],
        "kind": [b"x" * len(image), signed(b"x" * len(image))],
        "damaged": [bytes(flipped)],
        "foreign": [other_parameters, exchanged, with_word(image, 1, 3)],
        "invalid": [
            with_word(image, 10, 1),  # a flag that no controller keeps
            with_word(image, 3, 2**31),  # a negative count
            with_word(image, 16, 0x7FF00000),  # infinity
            with_word(
                image, len(image) // 4 - 2, 0x40590000
            ),  # a play at 100, far from its neighbour
        ],
    }
    for fault, images in bad.items():
        for wrong in images:
            with pytest.raises(ParameterError, match="not restored") as caught:
                controller.restore(wrong)
            assert caught.value.facts["fault"] == fault
            assert controller.save() == image


@pytest.mark.parametrize(
    "term", [25, 27, 29, 31], ids=["integrator", "difference", "mean", "exchanged"]
)
def test_a_restored_term_that_fades_never_grows_and_ends(term):
    controller = JointController(JOINT, MODEL)
    controller.reset(0.0, 3e5, 3e5)
    reference = JointReference(mean_pressure=3e5)
    controller.step(0.0, 3e5, 3e5, reference, 0)
    image = controller.save()

    def forged(value, step):
        at = 4 * (15 + 2 * term)
        return signed(image[:at] + struct.pack("<2d", value, step) + image[at + 16 :])

    with pytest.raises(ParameterError) as caught:
        controller.restore(forged(1e3, 0.0))  # would never end
    assert caught.value.facts["fault"] == "invalid"
    controller.restore(forged(1e3, -50.0))  # a step of the wrong sign counts by its size
    outputs = [controller.step(0.0, 3e5, 3e5, reference, 0) for _ in range(2000)]
    assert abs(outputs[-1].desired_1 - 3e5) < 1.0


def test_the_step_makes_no_copies_that_become_library_calls():
    text = "".join(path.read_text(encoding="utf-8") for path in SOURCES)
    assert not re.search(r"=\s*\{\s*0\s*\}", text)
    assert not re.search(r"\*state\s*=|= \*(reference|sensors)", text)
