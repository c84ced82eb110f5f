"""The generated type stubs say what is there."""

import ast
import inspect
from pathlib import Path

import pneudrive_py
from pneudrive_py import _pneudrive

STUB = Path(pneudrive_py.__file__).with_name("_pneudrive.pyi")
REGENERATE = "run: maturin generate-stubs -m python/Cargo.toml -o python/python/pneudrive_py"


def stubbed():
    """Names of classes with their members, and functions with their arguments."""
    classes, functions = {}, {}
    for node in ast.parse(STUB.read_text()).body:
        if isinstance(node, ast.ClassDef):
            classes[node.name] = {member.name for member in node.body if isinstance(member, ast.FunctionDef)}
        elif isinstance(node, ast.FunctionDef):
            arguments = node.args.posonlyargs + node.args.args + node.args.kwonlyargs
            functions[node.name] = [argument.arg for argument in arguments]
    return classes, functions


def test_stubs_are_up_to_date():
    classes, functions = stubbed()
    for name in _pneudrive.__all__:
        thing = getattr(_pneudrive, name)
        if inspect.isclass(thing):
            public = {member for member in vars(thing) if not member.startswith("_")}
            assert public == {m for m in classes[name] if not m.startswith("_")}, f"{name}: {REGENERATE}"
        elif callable(thing):
            assert list(inspect.signature(thing).parameters) == functions[name], f"{name}: {REGENERATE}"
    there = {name for name in _pneudrive.__all__ if name != "__version__"}
    assert there == classes.keys() | functions.keys(), REGENERATE


def test_everything_public_is_documented():
    for name in pneudrive_py.__all__:
        thing = getattr(pneudrive_py, name)
        if name in ("exceptions", "__version__"):
            continue
        assert thing.__doc__, name
        if inspect.isclass(thing):
            for method in vars(thing):
                if not method.startswith("_"):
                    assert getattr(thing, method).__doc__, f"{name}.{method}"
