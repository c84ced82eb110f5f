"""The generated type stubs say what is there."""

import ast
import builtins
import inspect
import subprocess
import sys
from pathlib import Path

import pneudrive_py
from pneudrive_py import _pneudrive

STUB = Path(pneudrive_py.__file__).with_name("_pneudrive.pyi")
REGENERATE = "run: maturin generate-stubs -m python/Cargo.toml -o python/python"


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


def test_a_type_checker_finds_in_the_stubs_what_is_there(tmp_path):
    """mypy's comparison of stubs with what Python finds at run time: names, arguments and their defaults."""
    command = [sys.executable, "-m", "mypy.stubtest", "pneudrive_py._pneudrive", "--concise"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_type_is_known():
    """No `Incomplete`, and no quoted type that names a module which the stub does not import."""
    text = STUB.read_text()
    assert "Incomplete" not in text, REGENERATE
    tree = ast.parse(text)
    known = {alias.asname or alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    known |= {
        alias.asname or alias.name for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    known |= {node.name for node in tree.body if isinstance(node, ast.ClassDef)} | set(dir(builtins))
    known = {name.split(".")[0] for name in known}
    hints = [argument.annotation for node in ast.walk(tree) if isinstance(node, ast.arguments) for argument in ast.walk(node) if isinstance(argument, ast.arg)]
    hints += [node.returns for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    used = set()
    for hint in filter(None, hints):
        if isinstance(hint, ast.Constant) and isinstance(hint.value, str):
            hint = ast.parse(hint.value, mode="eval")
        used |= {node.id for node in ast.walk(hint) if isinstance(node, ast.Name)}
    assert used <= known, f"{used - known}: {REGENERATE}"
    assert {"NDArray", "ArrayLike"} <= used | {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}


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
