"""Options of the tests of the program."""
import os
import pathlib

import pytest

pytest.register_assert_rewrite("support")


def pytest_addoption(parser):
    parser.addoption("--program", help="the program under test (build/release/explore/pavescape)")
    parser.addoption("--count", help="how many random cases, where a test draws some")


def pytest_configure(config):
    for option, variable in (("--program", "PAVESCAPE"), ("--count", "PAVESCAPE_COUNT")):
        if config.getoption(option) is not None:
            os.environ[variable] = config.getoption(option)
    program = pathlib.Path(os.environ.get("PAVESCAPE", pathlib.Path(__file__).resolve().parents[2] / "build/release/explore/pavescape"))
    if not program.exists():
        raise pytest.UsageError(f"{program} is not there: build it (cmake --build --preset release --target pavescape), or name another with --program")
