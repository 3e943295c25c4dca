"""What the documentation says, done."""

import ast
import doctest
import inspect
import pathlib
import re

import pytest

import pickline
from pickline import _pickline

README = pathlib.Path(__file__).parents[1] / "README.md"
EXAMPLES = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.parametrize("code", EXAMPLES)
def test_examples_of_the_readme_run(code, capsys):
    exec(compile(code, str(README), "exec"), {})
    assert capsys.readouterr().out


def test_there_are_examples():
    assert len(EXAMPLES) == 5


def test_examples_of_docstrings_run():
    result = doctest.testmod(pickline)
    assert result.attempted >= 4 and result.failed == 0


def test_everything_public_is_documented():
    for name in pickline.__all__:
        value = getattr(pickline, name)
        assert name == "__version__" or value.__doc__, name


def documented(tree):
    """Every definition of a stub with its docstring, and with whether it is there."""
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            yield node.name, ast.get_docstring(node)
            for method in node.body:
                if isinstance(method, ast.FunctionDef) and not method.name.startswith("__"):
                    yield f"{node.name}.{method.name}", ast.get_docstring(method)
        elif isinstance(node, ast.FunctionDef):
            yield node.name, ast.get_docstring(node)


def test_stubs_are_those_of_the_module():
    stub = pathlib.Path(pickline.__file__).with_name("_pickline.pyi")
    tree = ast.parse(stub.read_text(encoding="utf-8"))
    seen = set()
    for name, doc in documented(tree):
        value = _pickline
        for part in name.split("."):
            value = getattr(value, part)
        seen.add(name)
        if doc is not None:
            assert inspect.getdoc(value) == doc, name
    for name in ("Station", "Pattern", "Batch", "Report"):
        members = {f"{name}.{member}" for member in vars(getattr(_pickline, name))}
        assert {member for member in members if "._" not in member} <= seen
    public = {name for name in vars(_pickline) if not name.startswith("_")}
    assert public - {"OBSERVATION_VERSION"} <= seen
    for name, doc in documented(tree):
        assert doc or name.startswith("Batch."), name
