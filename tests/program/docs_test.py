"""Every `pavescape` command that README, CONTRIBUTING and docs show works: run for a few seconds, then interrupted. (Those of the
tutorial are run to their end, word by word: tutorial_test.py.)"""
import os
import re
import signal

from support import *

SECONDS = 2
reader = reader_of_pages()
commands = 0
for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]:
    for line in page.read_text().splitlines():
        found = re.match(r"    (?:\$ )?(pavescape .*?)(?:\s+#.*)?$", line)
        if not found or page.name == "tutorial.md" or re.search(r"\b(STUDY|RUN|FILE)\b", found[1]):
            continue
        commands += 1
        process = subprocess.Popen(found[1], shell=True, executable="/bin/bash", **reader, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True, start_new_session=True)
        try:
            message = process.communicate(timeout=SECONDS)[1]
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGINT)
            message = process.communicate(timeout=60)[1]
        unfinished = "holds no run" in message or "no run here" in message or "no figures" in message or "no such figure" in message  # of a run that was interrupted above
        check(process.returncode in (0, 130, -signal.SIGINT) or unfinished, f"{page.name}: {found[1]}: {process.returncode}: {message}")
        print(f"{page.name}: {found[1]}: {process.returncode}")
check(commands > 20, f"README and docs have commands: {commands}")
finish()
