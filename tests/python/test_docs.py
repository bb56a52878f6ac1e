"""What is written about the module: the examples of its page run, and its stubs say what is there."""

import ast
import inspect
import pathlib
import re
import shutil

import lanewright

from conftest import ROOT, SAMPLE


def test_the_examples_of_the_page_run(tmp_path, monkeypatch):
    page = (ROOT / "docs" / "python.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) >= 6
    shutil.copy(SAMPLE, tmp_path)
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
    assert pathlib.Path("my_map", "lanelet2_map.osm").is_file()


def members(node):
    return {one.name for one in node.body if isinstance(one, ast.FunctionDef)} - {"__len__", "__bool__", "__iter__"}


def test_the_stubs_say_what_is_there():
    stub = ast.parse(pathlib.Path(lanewright.__file__).with_name("_lanewright.pyi").read_text())
    classes = {one.name: one for one in stub.body if isinstance(one, ast.ClassDef)}
    functions = {one.name: one for one in stub.body if isinstance(one, ast.FunctionDef)}
    public = {name for name in lanewright.__all__ if not name.startswith("__")}
    assert public == set(classes) | set(functions)
    for name, node in functions.items():
        arguments = [one.arg for one in node.args.args + node.args.kwonlyargs]
        assert arguments == list(inspect.signature(getattr(lanewright, name)).parameters), name
    for name, node in classes.items():
        thing = getattr(lanewright, name)
        if not issubclass(thing, Exception):
            assert members(node) == {one for one in vars(thing) if not one.startswith("_")}, name
