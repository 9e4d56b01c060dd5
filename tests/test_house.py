"""Rules of the layout that no other tool checks: import loops, private names, sizes."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
MOST_LINES, MOST_PARAMETERS, MOST_REACHED = 350, 12, 100


def module_of(path: Path) -> str:
    """Dotted name of a file; a package has the name of its folder."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


PATHS = {module_of(p): p for top in ("surfaces", "asperity") for p in (ROOT / top).rglob("*.py")}
TREES = {module: ast.parse(path.read_text()) for module, path in PATHS.items()}


def folder(module: str) -> str:
    """Package that holds a module; a package is in itself."""
    return module if PATHS[module].name == "__init__.py" else module.rpartition(".")[0]


def imported(module: str) -> Iterator[tuple[str, str]]:
    """Modules of this project that a module imports anywhere, and the name taken from each."""
    for node in ast.walk(TREES[module]):
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names if alias.name in PATHS)
        if isinstance(node, ast.ImportFrom):
            above = folder(module).split(".")
            base = above[: len(above) + 1 - node.level] if node.level else []
            source = ".".join([*base, *([node.module] if node.module else [])])
            for alias in node.names:
                if f"{source}.{alias.name}" in PATHS:
                    yield f"{source}.{alias.name}", ""
                elif source in PATHS:
                    yield source, alias.name


GRAPH = {module: {target for target, _ in imported(module)} for module in PATHS}


def reached(start: str) -> set[str]:
    """Modules that are imported with one, the packages around them left out."""
    found, open_ = {start}, [start]
    while open_:
        new = GRAPH[open_.pop()] - found
        found |= new
        open_ += new
    return found


def parameters(node: ast.FunctionDef) -> int:
    given = node.args
    return len(given.posonlyargs + given.args + given.kwonlyargs)


def test_no_import_loop():
    """Imports for annotations and inside functions count."""
    try:
        TopologicalSorter(GRAPH).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


def test_no_private_name_is_imported_across_folders():
    taken = [
        f"{module}: {target} {name}"
        for module in PATHS
        for target, name in imported(module)
        if folder(target) != folder(module)
        and ((name.startswith("_") and not name.startswith("__")) or private(target))
    ]
    assert not taken, taken


def private(module: str) -> bool:
    return module.rpartition(".")[2].startswith("_") and not module.endswith("__main__")


def test_files_are_short():
    long = {m: n for m, p in PATHS.items() if (n := p.read_text().count("\n")) > MOST_LINES}
    assert not long, long


def test_functions_outside_kernels_have_few_parameters():
    many = {
        f"{module}.{node.name}": count
        for module, tree in TREES.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and (count := parameters(node)) > MOST_PARAMETERS
        if not compiled(module)
    }
    assert not many, many


def compiled(module: str) -> bool:
    """Whether a module holds compiled loops, whose arguments are scalars and arrays."""
    tools = ("surfaces.numerics.compiled", "surfaces.numerics.lanes", "surfaces.numerics.vectors")
    return any(target.startswith(tools) for target in GRAPH[module])


def test_a_contact_curve_reaches_few_modules():
    assert len(reached("asperity.curve")) <= MOST_REACHED, sorted(reached("asperity.curve"))


def test_no_module_is_imported_by_a_string():
    """But for a package that is optional."""
    by_name = [
        f"{module}: {ast.unparse(node)}"
        for module, tree in TREES.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module")
        if not ast.unparse(node).endswith("('SurfaceTopography')")
    ]
    assert not by_name, by_name
