"""Layers never point upwards, only study/ and what stands above the analyses know the forward model, each file is in the build, the map of
CONTRIBUTING is true, sizes stay within bounds, and the commands and tools that README, CONTRIBUTING and docs/reference/commands.md show exist."""
import re

from support import *

SRC = ["base", "mechanics", "material", "layered", "mesh", "fe", "pavement", "reduced"]
EXPLORE = ["data", "inference", "problem", "external", "study", "search", "optimise", "run", "landscape", "hypotheses", "diagnose", "analysis", "report", "cli"]
# Above the forward model's own base/, these may include src/.
KNOWS_PAVEMENTS = {"study", "analysis", "report", "cli"}
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text()


def includes(path):
    return re.findall(r'^#include "([^"]+)"', path.read_text(), re.M)


def layer(include):
    return include.split("/")[0]


def test_layers_never_point_upwards():
    for folder, layers in (("src", SRC), ("explore", EXPLORE)):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            own = path.relative_to(ROOT / folder).parts[0]
            assert own in layers, f"{path}: in no layer"
            for include in includes(path):
                other = layer(include)
                if other in layers:
                    assert layers.index(other) <= layers.index(own), f"{path.relative_to(ROOT)} points upwards to {include}"
                elif folder == "explore" and other in SRC:
                    assert other == "base" or own in KNOWS_PAVEMENTS, f"{path.relative_to(ROOT)} knows the forward model: {include}"
                else:
                    assert False, f"{path.relative_to(ROOT)}: {include} is in no layer it may see"
            if path.suffix == ".cpp":
                relative = path.relative_to(ROOT / folder)
                listed = (ROOT / folder / "CMakeLists.txt").read_text()
                assert str(relative) in listed or f"{own}/*.cpp" in listed or re.search(rf"set\((computing|arranging) [^)]*\b{own}\b", listed), f"{path} is not built"


def test_the_map_of_contributing_is_true():
    # The map of CONTRIBUTING names every folder of src/ and explore/ once, and no other.
    named = re.findall(r"^    (\S+/\S+) ", CONTRIBUTING.split("<!-- map -->")[1].split("<!-- end -->")[0], re.M)
    folders = [f"{top}/{folder.name}" for top in ("src", "explore") for folder in (ROOT / top).iterdir() if folder.is_dir()]
    assert sorted(named) == sorted(folders), f"CONTRIBUTING's map against the folders: {sorted(set(named) ^ set(folders)) or 'named twice'}"
    for layers, top in ((SRC, "src"), (EXPLORE, "explore")):
        assert [name for name in named if name.startswith(top + "/")] == [f"{top}/{layer}" for layer in layers], f"CONTRIBUTING's map lists {top}/ lowest first"


def private_names(text):
    """Types, functions and constants of unnamed namespaces; an alias of the same thing may stand twice."""
    for part in re.findall(r"^namespace \{\n(.*?)^\} // namespace$", text, re.M | re.S):
        for line in part.split("\n"):
            if found := re.match(r"(?:class|struct|enum class) (\w+).*\{|constexpr [\w:<>, ]*?(\w+)(?:\[\])? ?[={]|[\w:][\w:<>,&* ]* [*&]?(\w+\(.*)", line):
                name = found[1] or found[2] or re.sub(r"\b\w+(?=[,)])", "", found[3])
                if not line.startswith(("return", "template", "using")):
                    yield name


def test_sources_of_a_folder_have_private_names_of_their_own():
    # Several of them are compiled as one unit; and what is the same stands in one place.
    seen = {}
    for path in sorted((ROOT / "explore").rglob("*.cpp")):
        for name in set(private_names(path.read_text())):
            other = seen.setdefault((path.parent, name), path)
            assert other == path, f"{name} is private to {path.relative_to(ROOT)} and to {other.name}"


MOST_LINES = 500
# Longer files, each with the reason why it is one file.
LONGER = {
    "explore/study/keys.h": "one table: every key of a study with its range and meaning, which docs/reference/keys.md is made of",
    "explore/landscape/uniqueness.cpp": "one class: the steps of the analysis share its minima, walks and chain numbers",
    "explore/landscape/posterior.cpp": "one sampler: its populations, kernels and schedule share the particles",
    "explore/report/web/report.js": "one page: its sections share the building blocks at the top, and one script is what a page embeds",
    "explore/run/cluster.cpp": "both ends of one protocol stand side by side",
    "src/pavement/load_model.cpp": "one template: the finite element model of a load, at rest, over time and with its derivatives",
}


def lines_of(path):
    return len(path.read_text().splitlines())


def test_sizes_stay_within_bounds():
    files = [path for top in ("src", "explore", "python", "tools") for path in sorted((ROOT / top).rglob("*")) if path.suffix in (".h", ".cpp", ".js")]
    longer = {str(path.relative_to(ROOT)): lines_of(path) for path in files if lines_of(path) > MOST_LINES and str(path.relative_to(ROOT)) not in LONGER}
    assert not longer, f"more than {MOST_LINES} lines: {longer}"
    for name in LONGER:
        assert (ROOT / name).exists() and lines_of(ROOT / name) > MOST_LINES, f"{name} is no longer a file of more than {MOST_LINES} lines: take it off the list"
    sources = list((ROOT / "explore" / "cli").iterdir())
    cli = sum(lines_of(path) for path in sources)
    assert cli < 70 * len(sources), f"explore/cli has {cli} lines in {len(sources)} files: what computes belongs into explore/analysis, what renders into explore/report"
    assert lines_of(ROOT / "README.md") <= 100, f"README has {lines_of(ROOT / 'README.md')} lines, more than 100"


def test_pages_show_commands_and_tools_that_exist():
    for page, least in (("README.md", 1), ("docs/reference/commands.md", 15), ("CONTRIBUTING.md", 0)):
        text = (ROOT / page).read_text()
        commands = re.findall(r"^ +(?:\$ )?pavescape (\w+) ?(\S*)", text, re.M)
        assert len(commands) >= least, f"{page} shows the commands"
        for name, study in commands:
            assert run(name, "--help").returncode == 0, f"{page}: pavescape {name} is not a command"
            if study.startswith("grids/"):
                assert (ROOT / study).exists(), f"{page}: {study} is not there"


def test_every_command_and_tool_is_described():
    # Every command and every tool is described, and no page points to one that is not there.
    shown = (ROOT / "docs/reference/commands.md").read_text()
    for name in re.findall(r'^        \{"(\w+)", add_', (ROOT / "explore" / "cli" / "commands.cpp").read_text(), re.M):
        assert f"    pavescape {name}" in shown, f"docs/reference/commands.md does not show {name}"
    for path in (ROOT / "tools").rglob("*"):
        if path.is_file() and "." not in path.name:
            assert f"`{path.relative_to(ROOT)}" in CONTRIBUTING, f"CONTRIBUTING does not name {path.relative_to(ROOT)}"


def test_every_file_of_tests_is_run():
    listed = (ROOT / "tests" / "CMakeLists.txt").read_text()
    for path in sorted((ROOT / "tests").glob("*/*_test.*")):
        name = path.stem.removesuffix("_test") if path.suffix == ".py" else str(path.relative_to(ROOT / "tests"))
        assert re.search(rf"(?<![\w/]){re.escape(name)}(?![\w/])", listed), f"tests/CMakeLists.txt does not name {path.relative_to(ROOT)}"


def test_links_of_pages_lead_somewhere():
    for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")]:
        for target in re.findall(r"\]\(([\w./-]+\.(?:md|svg))[)#]", page.read_text()):
            assert (page.parent / target).exists(), f"{page.name}: {target} is not there"
        for script in re.findall(r"(?:`|    )(tools/[\w./-]+)", page.read_text()):
            assert (ROOT / script).exists(), f"{page.name}: {script} is not there"
        for target in re.findall(r"`(docs/[\w/-]+\.md)`", page.read_text()):
            assert (ROOT / target).exists(), f"{page.name}: {target} is not there"
