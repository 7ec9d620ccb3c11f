"""Every command of the tutorial, as it stands there: it works, and what the page shows of its output is its output. One story, one test."""
import re

from support import *


def test_the_tutorial_shows_what_its_commands_print():
    reader = reader_of_pages()
    page = (ROOT / "docs/guide/tutorial.md").read_text()
    # Indented blocks: "$ command", then lines of its output; "..." stands for lines left out.
    blocks = re.findall(r"(?:^    .*\n)+", page, re.M)
    commands, stale = 0, []
    for block in blocks:
        lines = [line[4:].rstrip() for line in block.splitlines()]
        while lines:
            command = lines.pop(0)
            assert command.startswith("$ "), f"a block begins with a command: {command}"
            commands += 1
            done = subprocess.run(command[2:], shell=True, executable="/bin/bash", capture_output=True, text=True, **reader)
            assert done.returncode == 0, f"{command}: {done.stderr[-800:]}"
            printed = [" ".join(line.split()) for line in done.stdout.splitlines()]
            at = 0
            while lines and not lines[0].startswith("$ "):
                wanted = " ".join(lines.pop(0).split())
                if wanted in ("", "..."):
                    continue
                if wanted in printed[at:]:
                    at = printed.index(wanted, at) + 1
                else:
                    stale.append(f"{command} no longer prints: {wanted}\nbut\n{done.stdout}")
    assert not stale, "\n".join(stale)
    assert commands >= 6, f"the tutorial has commands: {commands}"
