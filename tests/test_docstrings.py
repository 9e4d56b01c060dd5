"""Each public function and class has an example, and it runs."""

from __future__ import annotations

import doctest
import inspect
import sys
from types import ModuleType

import pytest

import asperity
import surfaces

PUBLIC = {
    f"{package.__name__}.{name}": value
    for package in (surfaces, asperity)
    for name in package.__all__
    if not isinstance(value := getattr(package, name), ModuleType)
    and not (inspect.isclass(value) and issubclass(value, Exception))
    and callable(value)
}


def examples(name: str) -> list[doctest.DocTest]:
    """Examples of a public name; those of the methods of a class count."""
    value = PUBLIC[name]
    module = sys.modules[value.__module__]
    finder = doctest.DocTestFinder(exclude_empty=True)
    return [one for one in finder.find(value, name, module=module) if one.examples]


@pytest.mark.parametrize("name", PUBLIC)
def test_the_example_runs(name, here):
    found = examples(name)
    assert found, f"{name} has no example"
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS)
    for one in found:
        runner.run(one)
    assert runner.summarize(verbose=False).failed == 0
