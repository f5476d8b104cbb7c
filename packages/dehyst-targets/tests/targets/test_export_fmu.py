"""An exported FMU is valid, answers like the model in every importer at hand, and survives every sequence of calls.

Random call sequences: `tests/support/fmu_sequences.c`, 25 000 of each version, here and for the joint controller. More,
or another seed:
    DEHYST_FMU_SEQUENCES=1000000 DEHYST_FMU_SEED=2 pytest tests/test_export_fmu*.py -k sequences
"""

import ctypes
import os
import re
import shutil
import subprocess
import sys
import zipfile
from contextlib import suppress
from dataclasses import replace
from functools import cache
from importlib import metadata
from pathlib import Path
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dehyst.export import Check, export, subject_of, verify
from dehyst.export._signal import same_bits
from dehyst.export.compilers import check_folder
from dehyst.families import example
from dehyst.models import (
    Block,
    ModelCard,
    ModifiedPrandtlIshlinskii,
    MonotoneMap,
    PrandtlIshlinskii,
    SignalCard,
)
from dehyst.units import TABLE
from dehyst_robot.control import JointControllerParameters
from dehyst_robot.export import joint_subject
from dehyst_targets.fmu import _sources as sources
from dehyst_targets.fmu import _verification as verification
from dehyst_targets.fmu import package
from dehyst_targets.fmu._description import (
    Description,
    Variable,
    base_unit,
    model_description,
    placed,
)
from dehyst_targets.fmu._interface import fmu_interface
from dehyst_targets.fmu._package import STEP, step_of
from dehyst_targets.fmu._sources import LINUX, WINDOWS
from dehyst_targets.fmu._terminals import picture
from dehyst_targets.fmu._verification import run_fmu
from export_samples import make_check
from fmu_tools import (
    CC,
    COMPILED,
    NEEDS_COMPILER,
    Importer,
    fmpy,
    quickly,
    readme_commands,
    readme_simulation,
    run_sequences,
)

pytestmark = NEEDS_COMPILER
CARD = ModelCard(
    SignalCard("pressure", "bar", -1.0, 1.5), SignalCard("angle [1]", "furlong", -2.0, 2.5)
)


def models():
    plain = PrandtlIshlinskii([0.0, 0.3, 0.5], [1.0, 0.7, 0.3], center=0.1, offset=-0.2, card=CARD)
    inner = PrandtlIshlinskii([0.0, 0.2, 0.6], [0.8, 0.4, 0.2])
    return {
        "pi": plain,
        "modified": ModifiedPrandtlIshlinskii(
            inner, MonotoneMap([-2.0, 0.0, 3.0], [-3.0, 0.5, 2.0]), card=CARD
        ),
    }


@pytest.fixture(autouse=True, scope="module")
def quick():
    with quickly():
        yield


@cache
def unit(family="pi", what="inverse", real="double", name="joint_1"):
    return subject_of(
        models()[family], what, name=name, real=real, excerpt=np.sin(np.arange(100) * 0.1)
    )


@cache
def made(version, *which):
    return package(unit(*which), version)


def written(folder, version, *which):
    """Path of the FMU of a unit."""
    path = folder / f"{unit(*which).name}{version}.fmu"
    path.write_bytes(made(version, *which).fmu)
    return path


@pytest.fixture(scope="module")
def subject():
    return unit()


@pytest.fixture(scope="module", params=[2, 3], ids=["fmi2", "fmi3"])
def fmu(request, subject, tmp_path_factory):
    """The exported folder of a version."""
    folder = tmp_path_factory.mktemp("fmu") / f"out{request.param}"
    export(subject, f"fmu{request.param}", folder)
    return request.param, folder


@pytest.mark.skipif(
    shutil.which(WINDOWS.compilers[0]) is None, reason="needs a cross compiler for Windows"
)
def test_a_cross_compiler_adds_a_library_for_windows(tmp_path):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sources, "TARGETS", (LINUX, WINDOWS))
        patch.setattr(sources, "find_spec", lambda name: None)  # no zig
        both = package(unit(), 2).binaries
    assert sorted(both.files) == ["binaries/linux64/joint_1.so", "binaries/win64/joint_1.dll"]
    assert both.files["binaries/win64/joint_1.dll"][:2] == b"MZ"


def test_an_fmu_without_any_compiler_holds_its_sources_and_says_what_is_missing(
    tmp_path, monkeypatch
):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sources, "TARGETS", (LINUX, WINDOWS))
        patch.setattr(sources, "find_spec", lambda name: None)  # no zig
        export(unit(), "fmu2", tmp_path / "out")
        checks = {check.claim: check for check in verify(tmp_path / "out")}
    assert (
        "No binary for linux64: no cc or gcc or clang"
        in (tmp_path / "out" / "README.md").read_text()
    )
    stepped = checks["the FMU's binary answers the test signal like the model"]
    assert stepped.status == "skipped"
    assert "fmpy compile joint_1.fmu" in stepped.detail
    monkeypatch.setattr(verification, "find_spec", lambda name: None)  # no FMPy
    without = [
        check
        for check in verification.check_fmu(tmp_path / "out", unit())
        if "pip install" in check.detail
    ]
    assert [check.status for check in without] == [
        "skipped"
    ] * 3  # test signal, excerpt, description
    assert {check.detail for check in without} == {
        "FMPy is not installed; type: pip install 'dehyst-targets[fmi]'"
    }


@pytest.mark.slow
def test_an_export_verifies_itself_and_notices_a_change(fmu, tmp_path):
    _, folder = fmu
    checks = verify(folder)
    assert all(check.ok for check in checks), checks
    assert (
        Check(
            "the FMU's binary answers the test signal like the model",
            "passed",
            "1060 samples, bits",
        )
        in checks
    )
    copy = shutil.copytree(folder, tmp_path / "copy")
    unit = copy / "sources" / "core" / "joint_1.c"
    unit.write_text(re.sub(r"0x1\.\w+p-1", "0x1.8p-1", unit.read_text(), count=1))
    wrong = {
        check.claim.split(" with")[0]
        for check in [*verify(copy), *check_folder(copy)]
        if not check.ok
    }
    assert wrong == {
        "files are as they were written",
        "files are those that dehyst exports from this model",
        "make check",
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    ("family", "what", "real"),
    [("pi", "inverse", "double"), ("modified", "forward", "double"), ("modified", "inverse", "double"),
     ("pi", "inverse", "float"), ("modified", "forward", "float")],
)  # fmt: skip
def test_both_versions_have_the_bits_of_the_model(family, what, real, tmp_path):
    subject = unit(family, what, real)
    both = [
        run_fmu(written(tmp_path, version, family, what, real), subject, subject.test)
        for version in (2, 3)
    ]
    found = [outputs for outputs, _ in both]
    assert same_bits(*found)
    assert np.ptp(found[0]) > 1
    if real == "double":
        assert same_bits(found[0], subject.test.outputs)
    else:
        assert np.abs(found[0] - subject.test.outputs).max() <= 1e-5 * np.ptp(subject.test.outputs)


@pytest.mark.slow
def test_the_same_model_gives_the_same_file_and_another_one_another_token(subject):
    first = made(2)
    COMPILED.clear()
    again = package(subject, 2)
    assert first.fmu == again.fmu
    assert (
        len(
            {
                made(2).token,
                made(3).token,
                made(2, "pi", "forward").token,
                made(2, "modified").token,
            }
        )
        == 4
    )


# ---- Importers.


def description(folder):
    with zipfile.ZipFile(folder / "joint_1.fmu") as packed:
        return Xml.fromstring(packed.read("modelDescription.xml"))


@pytest.mark.slow
@pytest.mark.parametrize("family", ["pi", "modified"])
@pytest.mark.parametrize("version", [2, 3])
def test_fmpy_finds_no_fault(family, version, tmp_path):
    fmpy()
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(written(tmp_path, version, family))) == []


@pytest.mark.slow
def test_the_simulation_of_the_readme_gives_the_expected_table(fmu):
    fmpy()
    result, expected = readme_simulation(fmu[1], "joint_1", ["pressure"])
    assert np.array_equal(result["time"], expected["time"])
    assert np.array_equal(result["pressure"], expected["pressure"])
    assert expected.size > 1000


def test_the_commands_of_the_readme_find_no_difference(fmu, tmp_path):
    fmpy()
    assert readme_commands(fmu[1], tmp_path) == [0.0, 0.0]  # time, pressure


@pytest.mark.slow
def test_what_fmpy_compiles_from_the_sources_answers_the_same(fmu, subject, tmp_path):
    fmpy()
    search = os.pathsep.join(
        [str(Path(sys.executable).parent), os.environ["PATH"]]
    )  # FMPy brings a cmake
    if shutil.which("cmake", path=search) is None:
        pytest.skip("needs cmake")
    path = tmp_path / "joint_1.fmu"
    with zipfile.ZipFile(fmu[1] / "joint_1.fmu") as packed, zipfile.ZipFile(path, "w") as bare:
        binaries = [name for name in packed.namelist() if name.endswith(".so")]
        for name in set(packed.namelist()) - set(
            binaries
        ):  # CMake does not replace a file that is a second old
            bare.writestr(name, packed.read(name))
    where = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PATH": search}
    subprocess.run(
        [sys.executable, "-m", "fmpy", "compile", str(path)],
        check=True,
        capture_output=True,
        env=where,
    )
    with zipfile.ZipFile(path) as packed:
        assert binaries and set(binaries) <= set(packed.namelist())
    assert same_bits(run_fmu(path, subject, subject.test)[0], subject.test.outputs)


def test_libcosim_gives_the_same_bits(subject, tmp_path):
    pytest.importorskip("libcosimpy")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    path = written(tmp_path, 2)
    execution = CosimExecution.from_step_size(1_000_000)
    slave = execution.add_local_slave(CosimLocalSlave(str(path), "joint"))
    observer, manipulator = CosimObserver.create_last_value(), CosimManipulator.create_override()
    execution.add_observer(observer)
    execution.add_manipulator(manipulator)
    found, flags = [], []
    for x, on in zip(subject.test.inputs[:, 0].tolist(), subject.test.switch.tolist(), strict=True):
        manipulator.slave_real_values(slave, [1], [x])
        manipulator.slave_boolean_values(slave, [3], [bool(on)])
        execution.step()
        found.append(observer.last_real_values(slave, [2])[0])
        flags.append(observer.last_integer_values(slave, [8])[0])
    assert same_bits(np.array(found), subject.test.outputs[:, 0])
    assert flags == subject.test.flags.tolist()


def ecos():
    """The package ecospy; its library needs oneTBB, which the package tbb brings."""
    with suppress(metadata.PackageNotFoundError, OSError):
        tbb = next(file for file in metadata.files("tbb") if file.name == "libtbb.so.12")
        ctypes.CDLL(str(tbb.locate()), ctypes.RTLD_GLOBAL)
    try:
        import ecospy
    except (ImportError, OSError) as fault:
        pytest.skip(f"needs ecospy and oneTBB: pip install ecospy tbb ({fault})")
    return ecospy


@pytest.mark.parametrize("version", [2, 3])
def test_ecos_gives_the_same_bits(version, subject, tmp_path):
    ecospy = ecos()
    path = written(tmp_path, version)
    with ecospy.EcosSimulationStructure() as structure:
        structure.add_model("joint", str(path))
        with ecospy.EcosSimulation(structure=structure, step_size=0.001) as simulation:
            simulation.init()
            found, flags = [], []
            for x, on in zip(
                subject.test.inputs[:, 0].tolist(), subject.test.switch.tolist(), strict=True
            ):
                simulation.set_real("joint::input", x)
                simulation.set_bool("joint::enable", bool(on))
                simulation.step()
                found.append(simulation.get_real("joint::pressure"))
                flags.append(simulation.get_integer("joint::flags"))
            simulation.terminate()
    assert same_bits(np.array(found), subject.test.outputs[:, 0])
    assert flags == subject.test.flags.tolist()


# ---- What an instance does.


def test_leaving_initialization_mode_sets_the_start_and_a_step_is_one_sample(fmu, subject):
    _, folder = fmu
    with Importer(folder / "joint_1.fmu") as one, Importer(folder / "joint_1.fmu") as other:
        for instance in (one, other):
            instance.enter()
            instance.set("input", [2.0])
            assert instance.get("pressure") == (subject.start_output,)
            instance.exit()
            assert instance.get("pressure") == (subject.start_output,)
        one.step(0.001)
        other.step(1000.0)
        assert one.get("pressure") == other.get("pressure") != (subject.start_output,)
        one.set("input", [float("nan")])
        one.step(0.001)
        assert one.get("rejected") == one.get("rejected_ever") == (1,)
        assert one.get("pressure") == other.get("pressure")
        assert other.get("flags") == (0,)


def test_constants_are_those_of_the_block_and_cannot_be_set(fmu, subject):
    version, folder = fmu
    with Importer(folder / "joint_1.fmu") as instance:
        names = ["threshold"] if version == 3 else [f"threshold[{k}]" for k in (1, 2, 3)]
        assert sum((instance.get(name) for name in names), ()) == subject.block.model.threshold
        assert instance.get("input_high") == (subject.block.input_high,)
        with instance.refuses("Set", "no input and no parameter: it cannot be set"):
            instance.set("input_high", [9.0])
        with instance.refuses("DoStep", "DoStep is not allowed: the FMU is instantiated"):
            instance.step(STEP)


# ---- Parameters, states, single precision, terminals.

WAVE = np.round(1.2 * np.sin(np.arange(200) * 0.1), 3)  # far from every limit of the block
PARAMETERS = {
    "output_scale": 1.0,
    "output_offset": 0.0,
    "output_low": -1.0,
    "output_high": 1.5,
    "fade": 1 / 500,
}


def answered(path, inputs, then=(), switches=()):
    """Answers (T,) of an instance to inputs; `then`: parameters set before a sample; `switches`: enable."""
    found = []
    with Importer(path) as instance:
        instance.enter()
        for k, x in enumerate(inputs):
            for name, value in dict(then).get(k, {}).items():
                instance.set(name, [value])
            if k in dict(switches):
                instance.set("enable", [dict(switches)[k]])
            instance.set("input", [x])
            if k == 0:
                instance.exit()
            instance.step(STEP)
            found.append(instance.get("pressure")[0])
    return np.array(found)


def model_answers(inputs, on=None, **more):
    """The same of the block that runs here."""
    return Block(models()["pi"], **more).run(
        inputs, on=np.ones(len(inputs), bool) if on is None else on
    )[0]


def test_parameters_begin_as_exported_and_change_no_bit(fmu):
    version, folder = fmu
    causality = {v.get("name"): v for v in description(folder).find("ModelVariables")}
    for name, value in PARAMETERS.items():
        told = causality[name]
        assert (told.get("causality"), told.get("variability")) == ("parameter", "tunable"), name
        assert float((told if version == 3 else told[0]).get("start")) == value, name
    path = folder / "joint_1.fmu"
    assert same_bits(answered(path, WAVE, {0: PARAMETERS, 50: PARAMETERS}), model_answers(WAVE))


def test_fmpy_sets_parameters_at_the_start_and_while_it_steps(fmu):
    simulate = fmpy().simulate_fmu
    time = STEP * np.arange(WAVE.size)
    columns = [("time", float), ("input", float), ("enable", bool), ("output_scale", float)]
    given = np.array(
        [
            (t, x, True, 1.0 if k < 100 else 0.5)
            for k, (t, x) in enumerate(zip(time, WAVE, strict=True))
        ],
        dtype=columns,
    )
    result = simulate(
        str(fmu[1] / "joint_1.fmu"), input=given, output_interval=STEP, stop_time=STEP * WAVE.size,
        output=["pressure"], start_values={"output_offset": 0.25},
    )  # fmt: skip
    scale = np.where(np.arange(WAVE.size) < 100, 1.0, 0.5)
    assert same_bits(result["pressure"][1:], 0.25 + scale * model_answers(WAVE))


def test_limits_that_are_set_hold_back_the_memory_too(fmu):
    wide = np.round(2.2 * np.sin(np.arange(200) * 0.1), 3)
    found = answered(fmu[1] / "joint_1.fmu", wide, {0: {"output_low": -0.4, "output_high": 0.5}})
    assert np.abs(found - model_answers(wide, range=(-0.4, 0.5))).max() < 1e-15
    assert not np.array_equal(found, model_answers(wide).clip(-0.4, 0.5))


def test_a_fade_of_one_switches_at_once(fmu):
    on = np.arange(WAVE.size) < 100
    found = answered(fmu[1] / "joint_1.fmu", WAVE, {0: {"fade": 1.0}}, {100: 0})
    assert same_bits(found, model_answers(WAVE, on, ramp=1))
    assert not np.array_equal(found, model_answers(WAVE, on))


WRONG = [("output_scale", 0.0), ("output_scale", -1.0), ("output_scale", float("nan")), ("output_offset", float("inf")),
         ("output_low", -1.1), ("output_high", 1.6), ("fade", 0.0), ("fade", 1.1)]  # fmt: skip


def test_a_parameter_that_cannot_be_is_refused_with_its_value_and_changes_nothing(fmu):
    with Importer(fmu[1] / "joint_1.fmu") as instance:
        instance.enter()
        for name, value in WRONG:
            before = instance.get(name)
            words = rf"cannot be {value:g}: .* -1 <= output_low <= output_high <= 1.5"
            with instance.refuses("Set", words):
                instance.set(name, [value])
            assert instance.get(name) == before
        instance.set("input", [0.7])
        instance.exit()
        instance.step(STEP)
        assert instance.get("pressure") == (model_answers([0.7])[0],)


def test_parameters_are_set_in_any_order_and_no_step_is_made_while_they_contradict_each_other(fmu):
    with Importer(fmu[1] / "joint_1.fmu") as instance:
        instance.enter()
        instance.set("output_high", [-0.5])
        instance.set("output_low", [0.5])
        with instance.refuses("ExitInitializationMode", "contradict each other"):
            instance.exit()
        instance.set("output_high", [1.0])
        instance.exit()
        assert instance.get("pressure") == (0.5,)  # the start, within the limits
        instance.set("output_low", [1.2])
        with instance.refuses("DoStep", "contradict each other"):
            instance.step(STEP)
        instance.set("output_high", [1.3])
        instance.step(STEP)
        assert instance.get("pressure") == (1.2,)


def test_parameters_go_back_with_the_state_and_with_a_reset(fmu):
    lib = fmpy()
    path = str(fmu[1] / "joint_1.fmu")
    about = lib.read_model_description(path)
    number = {v.name: v.valueReference for v in about.modelVariables}["output_scale"]
    slave = lib.instantiate_fmu(folder := lib.extract(path), about)
    three = fmu[0] == 3
    get, put = (slave.getFloat64, slave.setFloat64) if three else (slave.getReal, slave.setReal)
    put([number], [2.0])
    state = slave.getFMUState() if three else slave.getFMUstate()
    put([number], [3.0])
    (slave.setFMUState if three else slave.setFMUstate)(state)
    assert get([number])[0] == 2.0
    slave.reset()
    assert get([number])[0] == 1.0
    (slave.freeFMUState if three else slave.freeFMUstate)(state)
    slave.freeInstance()
    shutil.rmtree(folder)


def test_local_variables_are_the_states_of_the_plays(fmu):
    version, folder = fmu
    block = Block(models()["pi"])
    names = ["play_states"] if version == 3 else [f"play_states[{k}]" for k in (1, 2, 3)]
    with Importer(folder / "joint_1.fmu") as instance:
        instance.enter()
        instance.exit()
        for x in WAVE:
            instance.set("input", [x])
            instance.step(STEP)
            block.step(x)
            assert same_bits(
                np.array([value for name in names for value in instance.get(name)]), block.state
            )
    told = {v.get("name"): v for v in description(folder).find("ModelVariables")}[names[0]]
    assert told.get("causality") == "local" and (
        version == 2 or told.find("Dimension").get("start") == "3"
    )


@pytest.mark.slow
def test_local_variables_are_the_states_of_elements(tmp_path):
    subject = subject_of(replace(example("mixed-sum"), card=CARD), name="joint_1")
    path = tmp_path / "joint_1.fmu"
    path.write_bytes(package(subject, 3).fmu)
    block = subject.unit.block
    block.reset()
    with Importer(path) as instance:
        instance.enter()
        instance.exit()
        for x in WAVE:
            instance.set("input", [x])
            instance.step(step_of(subject))
            block.step(x)
            states = np.array(instance.get("element_states"))
            assert (
                states.size == subject.numbers.parts and states.tobytes() in block.save().tobytes()
            )


@pytest.mark.slow
def test_single_precision_is_float32_in_fmi_3_and_real_in_fmi_2(tmp_path):
    lib = fmpy()
    from fmpy.validation import validate_fmu

    which = ("pi", "inverse", "float")
    for version, kind in ((2, "Real"), (3, "Float32")):
        path = str(written(tmp_path, version, *which))
        assert validate_fmu(path) == []
        types = {v.name: v.type for v in lib.read_model_description(path).modelVariables}
        assert types.pop("time", "Float64") == "Float64"
        assert {
            types[name] for name in ("input", "pressure", "output_scale", "fade", "line_slope")
        } == {kind}
        assert {"Real", "Float32", "Float64"} & set(types.values()) == {kind}
        given = np.array(
            [(STEP * k, x, True) for k, x in enumerate(WAVE)],
            [("time", float), ("input", float), ("enable", bool)],
        )
        result = lib.simulate_fmu(
            path, input=given, output_interval=STEP, stop_time=STEP * WAVE.size, output=["pressure"],
            start_values={"output_scale": 0.5},
        )["pressure"]  # fmt: skip
        assert np.abs(result[1:] - 0.5 * model_answers(WAVE)).max() < 1e-5
        assert result.dtype == (np.float32 if version == 3 else np.float64)


def test_the_terminal_is_valid_and_has_every_input_and_output(tmp_path):
    etree, lib = pytest.importorskip("lxml.etree"), fmpy()
    with zipfile.ZipFile(written(tmp_path, 3)) as packed:
        text, svg = (
            packed.read(f"terminalsAndIcons/{name}")
            for name in ("terminalsAndIcons.xml", "icon.svg")
        )
        png, told = (
            packed.read(name) for name in ("terminalsAndIcons/icon.png", "modelDescription.xml")
        )
    schema = Path(lib.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    root = etree.fromstring(text)
    etree.XMLSchema(etree.parse(str(schema))).assertValid(root)
    signals = [
        v.get("name")
        for v in Xml.fromstring(told).find("ModelVariables")
        if v.get("causality") in ("input", "output")
    ]
    assert [member.get("variableName") for member in root.iter("TerminalMemberVariable")] == signals
    assert {"input", "pressure", "enable", "flags"} <= set(signals)
    assert Xml.fromstring(svg).tag.endswith("svg")
    with zipfile.ZipFile(written(tmp_path, 2)) as packed:
        assert packed.read("model.png") == png


def test_the_icon_is_a_picture_of_a_loop(tmp_path):
    image = pytest.importorskip("matplotlib.image")
    (tmp_path / "icon.png").write_bytes(picture())
    dark = image.imread(tmp_path / "icon.png") < 0.5
    assert dark.shape == (64, 64) and 0.05 < dark.mean() < 0.3
    assert dark[55, 18] and dark[32, 42] and dark[8, 46]  # along the bottom, up, along the top
    assert not dark[32, 32] and not dark[8, 8]


def test_a_signal_that_is_named_like_a_parameter_gets_another_name():
    card = ModelCard(SignalCard("fade", "bar", -1.0, 1.5), SignalCard("offset", "deg", -2.0, 2.5))
    subject = subject_of(replace(models()["pi"], card=card), name="joint_1")
    names = [v.name for v in fmu_interface(subject)]
    assert len(set(names)) == len(names) and names[:2] == ["input", "output"]


@pytest.mark.parametrize(
    ("part", "status", "words"),
    [
        (1e-14, False, "usable, not bit-equal"),
        (1e-3, True, "FAILED: do not use this build"),
        (0.0, False, "all checks passed"),
    ],
)
def test_the_check_tells_other_last_digits_from_wrong_ones(part, status, words, fmu, tmp_path):
    copy = shutil.copytree(fmu[1], tmp_path / "copy")
    unit = copy / "sources" / "core" / "joint_1.c"
    head, tail = unit.read_text().split("loading[] = {", 1)
    unit.write_text(head + "loading[] = {" + re.sub(
        r"0x1\.[0-9a-f]+p[+-]\d+", lambda told: (float.fromhex(told[0]) * (1 + part)).hex(), tail.partition("}")[0]
    ) + "}" + tail.partition("}")[2])  # fmt: skip
    done = make_check(copy, tmp_path / "build")
    assert bool(done.returncode) == status and words in done.stdout.splitlines()[-1], (
        done.stdout + done.stderr
    )


# ---- Times.


def test_a_step_back_needs_the_state(fmu):
    with Importer(fmu[1] / "joint_1.fmu") as instance:
        instance.enter()
        instance.exit()
        instance.step(0.5)
        instance.step(0.5)
        instance.time = 0.5
        with instance.refuses("DoStep", "go back with SetFMUState"):
            instance.step(0.5)


@pytest.mark.parametrize("start", [0.0, -3.0, 1e6, 1e9])
def test_no_step_is_taken_twice_however_late_it_is(start, fmu):
    with Importer(fmu[1] / "joint_1.fmu") as instance:
        instance.enter(start)
        instance.exit()
        for k in range(50):
            instance.time = (
                start + k * STEP
            )  # an importer's clock: off by roundings from the sum of steps
            instance.step(STEP)
        for wrong in (
            start,
            start + 48 * STEP,
            start + 49 * STEP,
            start + 49.9 * STEP,
            start + 51 * STEP,
        ):
            instance.time = wrong
            with instance.refuses("DoStep", "go back with SetFMUState"):
                instance.step(STEP)


@pytest.mark.parametrize("begin", [0.0, 9.999, 10.001, 10.1])
def test_the_first_step_begins_at_the_start_time(begin, fmu):
    with Importer(fmu[1] / "joint_1.fmu") as instance:
        instance.enter(10.0)
        instance.exit()
        instance.time = begin
        with instance.refuses("DoStep", "the experiment starts, at 10 s"):
            instance.step(STEP)
        instance.time = 10.0
        instance.step(STEP)


@pytest.mark.parametrize(
    ("begin", "length", "words"),
    [
        (1e308, 1e308, "is none"),
        (1e12, 1e-3, "cannot tell"),
        (1e300, 1.0, "cannot tell"),
        (0.0, float("inf"), "none"),
    ],
)
def test_a_step_that_leads_to_no_time_is_refused(begin, length, words, fmu):
    with Importer(fmu[1] / "joint_1.fmu") as instance:
        instance.enter(begin)
        instance.exit()
        with instance.refuses("DoStep", words):
            instance.step(length)
        assert instance.get("pressure") == (unit().start_output,)


@pytest.mark.slow
@pytest.mark.parametrize("real", ["double", "float"])
def test_what_is_beyond_all_physics_is_rejected_and_the_texts_say_so(real, tmp_path):
    limit = {"double": 1e100, "float": 1e15}[real]
    path = written(tmp_path, 2, "pi", "inverse", real)
    with zipfile.ZipFile(path) as packed:
        about = packed.read("modelDescription.xml").decode()
    assert f"infinite or beyond {limit:g}".replace("e+", "e") in about
    with Importer(path) as instance:
        instance.enter()
        instance.exit()
        for size in (1.1 * limit, 1e39, 1e200, 1.7e308, float("inf"), float("nan")):
            for x in (size, -size):
                for given in (0.5, x):
                    instance.set("input", [given])
                    instance.step(STEP)
                assert instance.get("rejected") == (int(not abs(x) <= limit),), x
        instance.set("input", [0.9 * limit])
        instance.step(STEP)
        assert instance.get("rejected") == (0,)
        assert instance.get("limited") == (1,)


@pytest.mark.slow
def test_no_number_beyond_float_is_converted_to_it(tmp_path):
    """C leaves that conversion undefined, and compilers' sanitizers do not look for it: the helper of the text does."""
    for which, version in [(("pi", "inverse", "float"), 2), (("modified", "forward", "float"), 3)]:
        text = made(version, *which).sources["unit.h"].decode()
        assert text.count("(dehyst_real)") == 1
        assert "return x > 3e38 ? 3e38f : x < -3e38 ? -3e38f : (dehyst_real)x;" in text
    joint = package(
        joint_subject(models()["pi"], JointControllerParameters(), name="joint_1", real="float"), 2
    )
    assert joint.sources["unit.h"].decode().count("(dehyst_real)") == 1


def test_a_state_is_kept_serialised_and_refused_when_damaged(fmu):
    lib, version = fmpy(), fmu[0]
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave

    path = str(fmu[1] / "joint_1.fmu")
    folder = lib.extract(path)
    about = lib.read_model_description(path)
    kind = FMU2Slave if version == 2 else FMU3Slave
    slave = kind(
        guid=about.guid, unzipDirectory=folder, modelIdentifier="joint_1", instanceName="a"
    )
    slave.instantiate()
    if version == 2:
        slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    read, write = (
        (slave.getReal, slave.setReal) if version == 2 else (slave.getFloat64, slave.setFloat64)
    )
    keep, back, free, pack, unpack = (
        (
            slave.getFMUstate,
            slave.setFMUstate,
            slave.freeFMUstate,
            slave.serializeFMUstate,
            slave.deSerializeFMUstate,
        )
        if version == 2
        else (
            slave.getFMUState,
            slave.setFMUState,
            slave.freeFMUState,
            slave.serializeFMUState,
            slave.deserializeFMUState,
        )
    )

    def walk(begin):
        out = []
        for k, x in enumerate([2.0, -1.0, 0.5]):
            write([1], [x])
            slave.doStep(begin + k * STEP, STEP)
            out.append(read([2])[0])
        return out

    walk(0.0)
    state = keep()
    first = walk(3 * STEP)
    back(state)
    assert walk(3 * STEP) == first
    bytes_ = bytes(pack(state))
    again = unpack(bytes_)
    back(again)
    assert walk(3 * STEP) == first
    for place in range(0, len(bytes_), 7):
        hurt = bytearray(bytes_)
        hurt[place] ^= 1
        with pytest.raises(Exception, match=r"[dD]e[sS]erializeFMU"):
            unpack(bytes(hurt))
    free(state)
    free(again)
    slave.terminate()
    slave.freeInstance()
    shutil.rmtree(folder)


# ---- The sources.

COMPILERS = [
    ("gcc", "-xc", "-std=c99"),
    ("gcc", "-xc", "-std=c11", "-O3"),
    ("g++", "-xc++", "-std=c++17"),
    ("clang", "-xc", "-std=c99"),
    ("clang++", "-xc++", "-std=c++17"),
]


@pytest.mark.parametrize("command", COMPILERS, ids="_".join)
def test_sources_compile_without_a_warning(command, fmu):
    if shutil.which(command[0]) is None:
        pytest.skip(f"{command[0]} is not there")
    flags = ["-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror", "-fsyntax-only"]
    subprocess.run([*command, *flags, str(fmu[1] / "sources" / "all.c")], check=True)


def test_the_example_runs_and_compiles_without_a_warning(fmu, tmp_path):
    flags = ["CFLAGS=-Wall -Wextra -Wpedantic -Werror", f"BUILD={tmp_path}"]
    done = subprocess.run(
        ["make", "-s", "-C", str(fmu[1]), "run", *flags], capture_output=True, text=True, check=True
    )
    lines = [line.split() for line in done.stdout.splitlines()]
    outputs = [float(line[3]) for line in lines if line[0] == "input"]
    assert len(outputs) == 9
    assert outputs == sorted(outputs)
    assert outputs[-1] > outputs[0]


def test_nothing_is_global_but_constants(fmu, tmp_path):
    source, made = str(fmu[1] / "sources" / "all.c"), str(tmp_path / "all.o")
    subprocess.run([CC, "-c", "-fno-pic", "-O1", source, "-o", made], check=True)
    symbols = subprocess.run(["nm", made], capture_output=True, text=True, check=True).stdout
    assert not re.findall(r" [dDbBcC] \w+", symbols)


def test_the_binary_shows_functions_of_the_standard_and_nothing_else(fmu, tmp_path):
    version, folder = fmu
    with zipfile.ZipFile(folder / "joint_1.fmu") as packed:
        path = packed.extract(
            next(name for name in packed.namelist() if name.endswith(".so")), tmp_path
        )
    shown = subprocess.run(
        ["nm", "-D", "--defined-only", path], capture_output=True, text=True, check=True
    ).stdout
    names = {line.split()[-1] for line in shown.splitlines()}
    assert all(name.startswith(f"fmi{version}") for name in names)
    assert len(names) == {2: 34, 3: 75}[version]
    needs = subprocess.run(
        ["nm", "-D", "--undefined-only", path], capture_output=True, text=True, check=True
    ).stdout
    used = {line.split()[-1].partition("@")[0] for line in needs.splitlines() if " U " in line}
    assert used <= {
        "calloc",
        "free",
        "snprintf",
        "vsnprintf",
        "strcmp",
        "memcpy",
        "memmove",
        "memset",
        "__stack_chk_fail",
    }


@pytest.mark.slow
@pytest.mark.parametrize("real", [(), ("float",)], ids=["another precision", "the same"])
def test_two_fmus_can_be_linked_into_one_program(real, tmp_path):
    lines = []
    for which in (("pi", "inverse", *real), ("modified", "forward", "float", "joint_2")):
        name = unit(*which).name
        for path, content in made(2, *which).sources.items():
            file = tmp_path / name / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
        prefix = f"-DFMI2_FUNCTION_PREFIX={name}_"
        subprocess.run(
            [CC, "-c", prefix, "all.c", "-o", f"../{name}.o"], cwd=tmp_path / name, check=True
        )
        lines.append(f"const char *{name}_fmi2GetVersion(void);")
    (tmp_path / "main.c").write_text(
        "\n".join(lines)
        + "\nint main(void) { return joint_1_fmi2GetVersion()[0] != joint_2_fmi2GetVersion()[0]; }\n"
    )
    subprocess.run([CC, "main.c", "joint_1.o", "joint_2.o", "-o", "both"], cwd=tmp_path, check=True)
    subprocess.run(["./both"], cwd=tmp_path, check=True)


@pytest.mark.exhaustive
def test_random_sequences_of_calls_never_crash(fmu, tmp_path):
    run_sequences(*fmu, tmp_path, "-DOUTPUT_LOW=-1.0", "-DOUTPUT_HIGH=1.5")


# ---- The description.


def test_every_unit_of_the_table_is_defined_by_base_units():
    for dimension, units in TABLE.items():
        for unit, factor in units.items():
            base = base_unit(unit)
            assert base is not None, dimension
            assert base.factor == factor
    assert base_unit("bar").exponents == base_unit("psi").exponents == {"kg": 1, "m": -1, "s": -2}
    assert base_unit("furlong") is None


def test_units_limits_and_roles_are_in_the_description(fmu):
    version, folder = fmu
    root = description(folder)
    units = {unit.get("name"): unit.find("BaseUnit") for unit in root.find("UnitDefinitions")}
    assert units["bar"].attrib == {"kg": "1", "m": "-1", "s": "-2", "factor": "100000.0"}
    assert units["furlong"] is None
    variables = {element.get("name"): element for element in root.find("ModelVariables")}
    of = variables["pressure"] if version == 3 else variables["pressure"][0]
    assert (of.get("unit"), of.get("min"), of.get("max"), of.get("nominal")) == (
        "bar",
        "-1.0",
        "1.5",
        "1.5",
    )
    assert (
        variables["input"].get("causality") == "input"
    )  # its name in the log, "angle [1]", is no name here
    assert "angle [1]" in variables["input"].get("description")
    simulation = root.find("CoSimulation").attrib
    assert (
        simulation["canBeInstantiatedOnlyOncePerProcess"]
        == simulation["needsExecutionTool"]
        == "false"
    )


@pytest.mark.slow
@given(st.lists(st.text(max_size=8), max_size=3), st.text(max_size=20), st.sampled_from([2, 3]))
def test_any_text_makes_a_description_that_can_be_parsed(units, text, version):
    variables = [
        Variable(f"v{k}", "real", "input", text, unit.strip(), (0.0,))
        for k, unit in enumerate(units)
    ]
    about = Description(
        "name", "{}", text, "tool", placed(variables, arrays=version == 3), None, 0.1, 1.0
    )
    root = Xml.fromstring(model_description(about, version))
    listed = [element.get("name") for element in root.find("ModelVariables")]
    assert listed == [*(["time"] if version == 3 else []), *(f"v{k}" for k in range(len(units)))]
