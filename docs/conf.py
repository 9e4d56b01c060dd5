"""Settings of the documentation site: `python -m sphinx -W docs build/site`. Needs no network."""

import re
import shutil
from pathlib import Path

import matplotlib

import asperity

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
STORIES = ROOT / "build" / "examples"

matplotlib.use("Agg")
# the gallery runs every script in its own folder: in a copy the results leave no trace
shutil.rmtree(STORIES, ignore_errors=True)
shutil.copytree(ROOT / "examples", STORIES, ignore=shutil.ignore_patterns("paper_figures.py"))

project = "asperity"
author = "the asperity developers"
release = asperity.__version__
extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "myst_nb",
    "sphinx_gallery.gen_gallery",
]
root_doc = "index"
exclude_patterns = ["gallery/*.ipynb", "gallery/*.py", "gallery/*.zip", "gallery/*.json"]
templates_path = ["templates"]
default_role = "py:obj"

autosummary_generate = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
python_maximum_signature_line_length = 80
napoleon_use_rtype = False
napoleon_use_ivar = True

myst_heading_anchors = 4
nb_execution_mode = "auto"
nb_execution_in_temp = True
nb_execution_timeout = 300
nb_execution_raise_on_error = True

sphinx_gallery_conf = {
    "examples_dirs": str(STORIES),
    "gallery_dirs": "gallery",
    "filename_pattern": r"/\d\d_",
    "ignore_pattern": r"__",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "show_memory": False,
    "abort_on_example_error": True,
    "write_computation_times": False,
}

html_theme = "furo"
html_title = "asperity"
html_show_sphinx = False
html_show_copyright = False
html_theme_options = {"light_css_variables": {"code-font-size": "0.72rem"}}


def _links_of_the_root(app, relative_path, parent, content):
    """Turn links between the pages of the root into links between the pages of the site."""
    if relative_path.parent == Path(".."):
        text = re.sub(r"\]\(docs/", "](/", content[0])
        text = re.sub(r"\]\((CONTRIBUTING|CHANGELOG)\.md", r"](/development/\1.md", text)
        text = text.replace("](examples/)", "](/gallery/index.rst)")
        content[0] = text.replace("](README.md", "](/index.md")


def setup(app):
    """Register the rewriting of links."""
    app.connect("include-read", _links_of_the_root)
