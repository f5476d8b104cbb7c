"""Everything public is documented, and the documented parameters exist."""

import importlib
import inspect
import pkgutil
import re

import dehyst
from places import SOURCES


def public_modules():
    names = [
        m.name
        for name, folder in SOURCES.items()
        for m in pkgutil.walk_packages([str(folder)], f"{name}.")
    ]
    return [
        importlib.import_module(n)
        for n in names
        if not n.endswith(("._native", ".__main__", ".kit", "._server"))
    ]


def public_objects():
    """Return every public function, class, method and property defined in the package, by dotted name."""
    found = {}
    for module in [dehyst, *public_modules()]:
        found[module.__name__] = module
        for name, value in vars(module).items():
            if name.startswith("_") or getattr(value, "__module__", None) != module.__name__:
                continue
            if inspect.isfunction(value) or inspect.isclass(value):
                found[f"{module.__name__}.{name}"] = value
            if inspect.isclass(value):
                for member, entry in vars(value).items():
                    if not member.startswith("_") and isinstance(
                        entry, (property, staticmethod, classmethod)
                    ):
                        found[f"{module.__name__}.{name}.{member}"] = entry
                    elif not member.startswith("_") and inspect.isfunction(entry):
                        found[f"{module.__name__}.{name}.{member}"] = getattr(value, member)
    return found


OBJECTS = public_objects()


def documented_names(text, section):
    """Return the names that a NumPy-style section lists."""
    match = re.search(rf"^{section}\n-+\n(.*?)(?=^\w[\w ]*\n-+\n|\Z)", text, flags=re.M | re.S)
    names = []
    for line in match[1].splitlines() if match else []:
        if line and not line.startswith(" "):
            names += [name.strip().lstrip("*") for name in line.split(" : ")[0].split(",")]
    return names


def test_every_public_name_is_found():
    assert len(OBJECTS) > 60
    assert set(dehyst.__all__) <= set(dir(dehyst))
    for name in dehyst.__all__:
        value = getattr(dehyst, name)
        assert name == "__version__" or inspect.getdoc(value), name


def with_section(section):
    """Public objects that have this section, with the names that it lists, by dotted name."""
    texts = {name: inspect.getdoc(value) or "" for name, value in OBJECTS.items()}
    found = {
        name: documented_names(text, section)
        for name, text in texts.items()
        if f"{section}\n---" in text
    }
    assert len(found) > 30 and all(found.values())
    return found


def test_every_public_object_has_a_docstring():
    assert [
        name for name, value in OBJECTS.items() if not (inspect.getdoc(value) or "").strip()
    ] == []


def test_documented_parameters_are_those_of_the_signature_in_its_order():
    for name, documented in with_section("Parameters").items():
        of = inspect.signature(getattr(OBJECTS[name], "__func__", OBJECTS[name])).parameters
        if any(
            p.kind is p.VAR_KEYWORD for p in of.values()
        ):  # settings of many families, documented behind it
            documented = [p for p in documented if p in of]
        assert documented == [p for p in of if p in documented], name


def test_documented_attributes_exist():
    for name, documented in with_section("Attributes").items():
        value = OBJECTS[name]
        declared = set(inspect.get_annotations(value)) | set(
            getattr(value, "__dataclass_fields__", ())
        )
        assert set(documented) <= declared | set(dir(value)), name


def test_every_public_name_shows_an_example_or_is_a_plain_base():
    for name in set(dehyst.__all__) - {"__version__"}:
        assert ">>>" in inspect.getdoc(getattr(dehyst, name)) or inspect.isabstract(
            getattr(dehyst, name)
        ), name


def test_sections_are_parsed_as_written():
    text = "Do.\n\nParameters\n----------\nx, y\n    Two.\n*rest\n    More.\n\nReturns\n-------\nz : (T,)\n    Out.\n"
    assert documented_names(text, "Parameters") == ["x", "y", "rest"]
    assert documented_names(text, "Returns") == ["z"]
    assert documented_names(text, "Raises") == []
