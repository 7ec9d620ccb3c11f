"""Every `pavescape` command that README, CONTRIBUTING and docs show works: run for a moment, in the second tier for a few seconds, then interrupted. (Those of the
tutorials are run to their end: tutorial_test.py, and below.)"""
import os
import re
import signal

import pytest

from support import *

COMMANDS = [(page.name, found[1]) for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
            for line in page.read_text().splitlines()
            if (found := re.match(r"    (?:\$ )?(pavescape .*?)(?:\s+#.*)?$", line))
            and page.name not in ("tutorial.md", "own-model-tutorial.md") and not re.search(r"\b(STUDY|RUN|FILE)\b", found[1])]


@pytest.fixture(scope="module")
def reader():
    return reader_of_pages()


def test_pages_have_commands():
    assert len(COMMANDS) > 20, f"README and docs have commands: {len(COMMANDS)}"


@pytest.mark.parametrize("page, command", COMMANDS)
@pytest.mark.parametrize("seconds", (0.5, pytest.param(2, marks=pytest.mark.long)))
def test_a_command_of_a_page_works(reader, page, command, seconds):
    process = subprocess.Popen(command, shell=True, executable="/bin/bash", **reader, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                               start_new_session=True)
    try:
        message = process.communicate(timeout=seconds)[1]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGINT)
        message = process.communicate(timeout=60)[1]
    # Of a run that was interrupted above.
    unfinished = any(words in message for words in ("holds no run", "no run here", "no figures", "no such figure"))
    assert process.returncode in (0, 130, -signal.SIGINT) or unfinished, f"{page}: {command}: {process.returncode}: {message}"


# --- the tutorial of a model of one's own: its files are those that it shows

OWN_MODEL = (ROOT / "docs" / "guide" / "own-model-tutorial.md").read_text()


def blocks(text):
    """[(the paragraph before, what an indented block says)]"""
    return [(before, re.sub(r"^    ", "", block, flags=re.M)) for before, block in re.findall(r"((?:^\S.*\n)*)\n((?:^    .*\n|^\n(?=    ))+)", text, re.M)]


def follow(folder, text):
    """Does what a page says, block by block: writes files that the paragraph before names, changes lines, runs commands, which print the lines below
    them. Gives what they printed."""
    said = []
    for before, block in blocks(text):
        named = re.findall(r"`([\w-]+\.\w+)`", before)
        if block.startswith("$ "):
            command, *lines = block[2:].strip().splitlines()
            done = subprocess.run(command, shell=True, executable="/bin/bash", cwd=folder, env=reader_of_pages()["env"], capture_output=True, text=True)
            assert done.returncode == 0, f"{command}: {done.stderr}"
            said.append(" ".join(done.stdout.split()))
            for shown in " ".join(lines).split("..."):  # of which some is left out
                assert " ".join(shown.split()) in said[-1], f"{shown}: {said[-1]}"
        elif "the line `files` becomes" in before:
            key = block.split("=")[0]
            file = folder / named[-1]
            lines = file.read_text().splitlines()
            lines[max(k for k, line in enumerate(lines) if line.startswith(key))] = block.strip()
            file.write_text("\n".join(lines) + "\n")
        else:
            (folder / named[-1]).write_text(block)
    return said


def test_the_files_of_the_tutorial_of_a_model_of_ones_own_run():
    upto = OWN_MODEL.index("## Is the answer")
    said = follow(workspace(), OWN_MODEL[:upto])
    assert len(said) == 1 and "18 min" in said[0], said


@pytest.mark.long
def test_the_tutorial_of_a_model_of_ones_own_ends_as_it_says():
    assert len(follow(workspace(), OWN_MODEL)) == 7


# --- links

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]


def without_code(text):
    return re.sub(r"^    .*$", "", text, flags=re.M)


def anchors(page):
    """Of its headings, as the pages are shown: lower case, blanks as hyphens, no other signs."""
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in re.findall(r"^#+ (.*)$", page.read_text(), re.M)}


def links(page):
    """[(file, anchor)] of what a page links to in this tree."""
    found = re.findall(r"\]\(([^)\s]+)\)", without_code(page.read_text()))
    return [((page.parent / target.split("#")[0]).resolve() if not target.startswith("#") else page, target.partition("#")[2])
            for target in found if not re.match(r"[a-z]+:", target)]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_somewhere(page):
    for target, anchor in links(page):
        assert target.exists(), f"{page.name}: {target}"
        if anchor and target.suffix == ".md":
            assert anchor in anchors(target), f"{page.name}: {target.name}#{anchor}"


# --- words and lines


def check(tool, *files):
    return subprocess.run([ROOT / "tools" / "check" / tool, *files], capture_output=True, text=True)


def test_no_text_stumbles_and_no_line_is_long():
    for tool in ("words", "columns"):
        done = check(tool)
        assert done.returncode == 0, done.stdout


def test_the_checks_find_what_they_are_for():
    folder = workspace()
    source, page = folder / "a.cpp", folder / "a.md"
    source.write_text('// What a run holds.\nint asked = 0; // `asked`\nauto text = "the data that were asked for";\n')
    done = check("words", source)
    assert done.returncode == 1 and [line.split(":")[1] for line in done.stdout.splitlines()] == ["1", "3"], done.stdout
    source.write_text("double cost_function = 0.0;\nclass CostFunction {};\nauto text = \"the surrogate model\";\nint cost = 0;\n")
    done = check("words", source)
    assert done.returncode == 1 and [line.split(":")[1] for line in done.stdout.splitlines()] == ["3", "1", "2"], done.stdout
    text = "- " + "word " * 40 + "\n\n| " + "cell " * 40 + "|\n\n    " + "code " * 40 + "\n"
    page.write_text(text)
    assert check("columns", page).returncode == 1
    assert check("columns", "--fix", page).returncode == 0 and check("columns", page).returncode == 0
    lines = page.read_text().splitlines()
    assert page.read_text().split() == text.split() and [len(line) > 120 for line in lines] == [False] * 3 + [True, False, True], lines


def test_every_page_is_reached_from_the_index():
    linked = {target for target, _ in links(ROOT / "docs" / "README.md")}
    pages = {page for page in (ROOT / "docs").rglob("*.md") if page.name != "README.md"}
    assert pages <= linked, f"not in docs/README.md: {sorted(page.name for page in pages - linked)}"
    assert (ROOT / "docs" / "README.md") in {target for target, _ in links(ROOT / "README.md")}


def test_every_page_of_evidence_says_which_program_its_numbers_are_of():
    rows = [line for line in (ROOT / "docs" / "README.md").read_text().splitlines() if "](evidence/" in line]
    for page in (ROOT / "docs" / "evidence").glob("*.md"):
        of = [row.split("|")[3] for row in rows if f"](evidence/{page.name})" in row]
        assert len(of) == 1 and re.search(r"\b[0-9a-f]{7}\b", of[0]), f"{page.name}: {of}"


def test_every_figure_is_in_the_gallery():
    listed = re.search(r"FIGURE +(.*?)\(default", " ".join(run("plot", "--help").stdout.split()))[1]
    drawn = [picture.stem for picture in (ROOT / "docs" / "guide" / "gallery").glob("*.svg")]
    rare = {"corrections"}  # where a diagnosis finds no effect, but a place
    for figure in set(name.strip() for name in listed.split(",")) - rare:
        assert any(name.endswith(f"-{figure}") for name in drawn), f"{figure}: {sorted(drawn)}"
