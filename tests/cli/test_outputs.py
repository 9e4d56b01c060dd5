"""Where a run may write: never over its input, over what is there only when told to."""

from __future__ import annotations

import os

import pytest
from refusals import STEEL, good_map, refusal

import surfaces
from asperity.cli.main import main


@pytest.mark.parametrize("command", ["curve", "bem", "compare"])
def test_no_folder_for_the_results_is_found_before_the_work(command, folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    arguments = [command, "scan.h5", *STEEL, "-o", "absent/results.h5"]
    assert "folder does not exist" in refusal(arguments, capsys)


OUTPUTS = {
    "curve": ["-o", "--csv", "--contacts", "--spots", "--sizes", "--fields", "--table", "--plot"],
    "bem": ["-o", "--csv", "--fields", "--slip"],
    "compare": ["-o", "--csv", "--report"],
    "indent": ["--plot"],
    "surface prepare": ["-o"],
    "surface peaks": ["-o", "--plot", "--fans"],
    "surface info": ["--report", "--table"],
}


@pytest.mark.parametrize(
    ("command", "option"), [(c, option) for c, named in OUTPUTS.items() for option in named]
)
def test_no_output_replaces_the_input_or_what_is_there(command, option, folder, capsys):
    """The one by no means, the other only where it is said."""
    surfaces.write(good_map(), folder / "scan.h5")
    (folder / "there.csv").write_text("mine")
    before = (folder / "scan.h5").read_bytes()
    material = [] if command.startswith("surface") else STEEL
    material = [*material, *(["--friction", "1"] if option == "--slip" else [])]
    call = [*command.split(), "scan.h5", *material, option]
    assert "would replace the input" in refusal([*call, "./scan.h5", "--force"], capsys)
    message = refusal([*call, "there.csv"], capsys)
    assert "there.csv is there already; --force replaces it" in message
    results = command in ("curve", "bem", "compare") and option == "-o"
    assert ("--resume goes on with it" in message) == results
    assert (folder / "scan.h5").read_bytes() == before
    assert {p.name for p in folder.iterdir()} == {"scan.h5", "there.csv"}


@pytest.mark.parametrize(
    ("call", "suffix"),
    [
        (["curve", "scan.h5", *STEEL, "-o", "a.csv"], ".h5"),
        (["curve", "scan.h5", *STEEL, "--csv", "a.h5"], ".csv"),
        (["curve", "scan.h5", *STEEL, "--csv", "a.xlsx"], ".csv"),
        (["curve", "scan.h5", *STEEL, "--fields", "a.csv"], ".vti"),
        (["curve", "scan.h5", *STEEL, "--fields", "a.png"], ".vti"),
        (["compare", "scan.h5", *STEEL, "--report", "a.csv"], ".html"),
        (["surface", "info", "scan.h5", "--table", "a.h5"], ".csv"),
        (["surface", "convert", "scan.h5", "-o", "a.html"], ".h5, .npz, .txt, .csv"),
        (["report", "results.h5", "-o", "a.h5"], ".html"),
    ],
)
def test_no_output_is_named_as_another_format(call, suffix, folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    assert f"it is written as {suffix}, not as {call[-1][1:]}" in refusal(call, capsys)
    assert {p.name for p in folder.iterdir()} == {"scan.h5"}


@pytest.mark.parametrize(
    "call",
    [
        ["surface", "info", "scan.h5", "--table", "new/"],
        ["surface", "info", "scan.h5", "--report", "new/"],
        ["surface", "generate", "--rms-slope", "0.1", "-o", "new/"],
        ["curve", "scan.h5", *STEEL, "--table", "new/"],
    ],
)
def test_one_file_for_all_is_not_named_as_a_folder(call, folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    assert "new/: cannot be written, it is the name of a folder" in refusal(call, capsys)
    assert {p.name for p in folder.iterdir()} == {"scan.h5"}


def test_a_map_made_by_blocks_is_hdf5(folder, capsys):
    call = ["surface", "generate", "--rms-slope", "0.1", "--shape", "16", "--memory", "8GiB"]
    assert "blocks are written as HDF5 alone" in refusal([*call, "-o", "a.csv"], capsys)
    assert not list(folder.iterdir())


def test_a_report_does_not_replace_its_results(folder, capsys):
    (folder / "results.h5").touch()
    message = refusal(["report", "results.h5", "-o", "results.h5"], capsys)
    assert "would replace the input" in message


def test_two_outputs_of_one_name(folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    call = ["compare", "scan.h5", *STEEL, "-o", "a.h5", "--report", "a.h5"]
    assert "two outputs" in refusal(call, capsys)


@pytest.mark.parametrize(
    "call", [["compare", *STEEL], ["surface", "prepare", "-o", "out/"]], ids=lambda c: c[0]
)
def test_two_inputs_of_one_name(call, folder, capsys):
    for place in ("a", "b"):
        (folder / place).mkdir()
        surfaces.write(good_map(), folder / place / "scan.h5")
    assert "replace each other" in refusal([*call, "a/scan.h5", "b/scan.h5"], capsys)


def test_a_folder_that_takes_no_files(folder, capsys, monkeypatch):
    """Permissions do not bind every user who runs the tests, so the refusal is played."""

    def refuse(**_: object) -> None:
        raise PermissionError(13, "Permission denied")

    surfaces.write(good_map(), folder / "scan.h5")
    monkeypatch.setattr("tempfile.TemporaryFile", refuse)
    assert "Permission denied" in refusal(["curve", "scan.h5", *STEEL], capsys)


def test_a_name_with_brackets_is_a_name_before_it_is_a_pattern(folder, capsys):
    surfaces.write(good_map().replace(name="odd"), folder / "scan[1].h5")
    surfaces.write(good_map(), folder / "scan1.h5")
    assert main(["surface", "validate", "scan[1].h5"]) == 0
    assert "scan[1].h5: valid" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["curve", "compare"])
def test_no_output_replaces_a_device_or_has_an_impossible_name(command, folder, capsys):
    """A file is written beside its place and renamed: under root that replaced /dev/null."""
    surfaces.write(good_map(), folder / "scan.h5")
    os.mkfifo(folder / "pipe")
    (folder / "circle").symlink_to("circle")
    for target, match in (
        ("pipe", "it is a device or a pipe"),
        ("circle", "cannot be written"),
        ("a" * 300, "cannot be written"),
        ("scan.h5/results.h5", "cannot be written"),
    ):
        assert match in refusal([command, "scan.h5", *STEEL, "-o", target], capsys)
    assert (folder / "pipe").is_fifo()
    assert {p.name for p in folder.iterdir()} == {"scan.h5", "pipe", "circle"}


def test_an_output_through_a_link_keeps_the_link(folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    (folder / "shelf").mkdir()
    (folder / "link.csv").symlink_to("shelf/table.csv")
    assert main(["surface", "peaks", "scan.h5", "-o", "link.csv"]) == 0
    assert (folder / "link.csv").is_symlink()
    assert (folder / "shelf" / "table.csv").read_text().startswith("x_m,y_m")


def test_one_file_by_two_names_is_read_once(folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    assert main(["surface", "info", "scan.h5", "./scan.h5", "--json"]) == 0
    assert capsys.readouterr().out.count('"file"') == 1


def test_a_name_as_long_as_the_folder_takes(folder, capsys):
    surfaces.write(good_map(), folder / "scan.h5")
    name = "a" * 251 + ".csv"
    assert main(["surface", "peaks", "scan.h5", "-o", name]) == 0
    assert (folder / name).is_file()


def test_a_file_name_that_is_no_text(folder, capsys):
    """Bytes of another encoding reach the name, the page and the terminal."""
    name = b"gr\xf6sse.h5".decode("utf-8", "surrogateescape")
    surfaces.write(good_map(), folder / name)
    assert main(["surface", "info", name, "--report", "page.html"]) == 0
    assert main(["surface", "prepare", name, "-o", "ready.h5"]) == 0
    assert main(["surface", "info", "ready.h5"]) == 0
    assert "gr?sse" in (folder / "page.html").read_text(encoding="utf-8")
