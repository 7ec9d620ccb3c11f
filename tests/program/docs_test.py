"""Every `pavescape` command that README, CONTRIBUTING and docs show works: run for a moment, in the second tier for a few seconds, then interrupted. (Those of the
tutorial are run to their end, word by word: tutorial_test.py.)"""
import os
import re
import signal

import pytest

from support import *

COMMANDS = [(page.name, found[1]) for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
            for line in page.read_text().splitlines()
            if (found := re.match(r"    (?:\$ )?(pavescape .*?)(?:\s+#.*)?$", line))
            and page.name != "tutorial.md" and not re.search(r"\b(STUDY|RUN|FILE)\b", found[1])]


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
