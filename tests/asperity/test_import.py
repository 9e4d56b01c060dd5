"""Importing the packages brings in numpy and nothing heavy."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = (
    "numba",
    "scipy",
    "cv2",
    "h5py",
    "pyfftw",
    "matplotlib",
    "jinja2",
    "tqdm",
    "pandas",
    "shtab",
    "distributed",
)


@pytest.mark.parametrize("package", ["asperity", "surfaces", "asperity.cli.main"])
def test_import_is_light(package):
    code = f"import sys, {package}; print([m for m in {HEAVY!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_only_the_command_used_is_imported():
    code = "import sys, asperity.cli.main as cli; cli.build_parser('warmup'); "
    code += "print([name for name in cli.COMMANDS if f'asperity.cli.{name}' in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "['warmup']"


@pytest.mark.parametrize("package", ["asperity", "surfaces"])
def test_every_public_name_resolves(package):
    module = __import__(package)
    assert module.__all__
    for name in module.__all__:
        assert getattr(module, name) is not None
    with pytest.raises(AttributeError, match="attribute nothing"):
        _ = module.nothing


@pytest.mark.parametrize("name", ["asperity.microcontact.Flag", "surfaces.shapes.polygon"])
def test_modules_that_the_pages_name_need_no_import_of_their_own(name):
    code = f"import asperity, surfaces; {name}"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_geometry_knows_nothing_of_mechanics():
    code = "import sys, surfaces; [getattr(surfaces, n) for n in surfaces.__all__]; "
    code += "print([m for m in sys.modules if m.split('.')[0] == 'asperity'])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_judge_shares_nothing_with_the_model():
    code = "import sys, asperity.bem, asperity; [getattr(asperity, n) for n in ('bem_curve',)]; "
    code += "judged = ('microcontact', 'interaction', 'population', 'curve', 'contacts'); "
    code += "print([m for m in sys.modules if m.startswith('asperity.') "
    code += "and m.split('.')[1] in judged])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
