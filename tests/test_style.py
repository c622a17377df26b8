# SPDX-License-Identifier: GPL-2.0-or-later
"""One format for all: what scripts/format would change is an error, and prose keeps to 110 columns and to the
words of pyproject.toml, too."""

import io
import re
import subprocess
import sys
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
COLUMNS = 110
PROSE = [*sorted(ROOT.glob("*.md")), ROOT / "AUTHORS", *sorted((ROOT / "doc").rglob("*.md"))]
VENV = ROOT / "build" / "venv"
FORMATTERS = [VENV / "bin" / name for name in ("ruff", "clang-format")]


def tooLong(text):
    """Numbers of the lines that are too long. A row of a table has to be one line in Markdown, and may be."""
    return [
        number
        for number, line in enumerate(text.splitlines(), 1)
        if len(line) > COLUMNS and not line.lstrip().startswith("|")
    ]


@pytest.mark.parametrize("page", PROSE, ids=lambda page: str(page.relative_to(ROOT)))
def test_prose_keeps_to_110_columns(page):
    assert tooLong(page.read_text()) == []


def test_control_a_long_line_is_found_and_a_row_of_a_table_is_not():
    assert tooLong(f"{'x' * 110}\n{'y' * 111}\n  | {'z' * 200} |\n") == [2]


tomllib = pytest.importorskip("tomllib", reason="Python 3.11 and later have it")
INSTEAD = {
    word: better
    for words, better in tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["prose"][
        "instead"
    ].items()
    for word in words.split(", ")
}


def refusedWords(text):
    """Words of the manual's sentences that readers do not know in this sense; code and names are left out."""
    bare = re.sub(r"^```.*?^```|`[^`]*`|\]\([^)]*\)", " ", text, flags=re.M | re.S)
    return [word for word in INSTEAD if re.search(rf"\b{word.replace(' ', chr(92) + 's+')}\b", bare, re.I)]


@pytest.mark.parametrize(
    "page", [p for p in PROSE if p.name != "SECURITY.md"], ids=lambda page: str(page.relative_to(ROOT))
)
def test_prose_uses_the_words_of_the_field(page):
    assert {word: f"write: {INSTEAD[word]}" for word in refusedWords(page.read_text())} == {}


def proseOf(source):
    """Comments, docstrings, texts and names of tests of a Python file, without what backticks enclose."""
    kinds = tokenize.COMMENT, tokenize.STRING
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type in kinds or token.string.startswith("test_"):
            yield re.sub("`[^`]*`", " ", token.string).replace("_", " ")


@pytest.mark.parametrize("folder", ["py", "scripts", "tests"])
def test_code_uses_the_words_of_the_field(folder):
    """Also names between quotes; a file of tests that names the words, and old names, may."""
    found = {}
    for file in sorted((ROOT / folder).rglob("*.py")):
        words = refusedWords("\n".join(proseOf(file.read_text()))) if file != Path(__file__) else []
        if words and words not in (["certificate"], ["mend"], ["stripes"]):
            found[str(file.relative_to(ROOT))] = words
    assert found == {}


def test_control_a_refused_word_in_a_comment_and_in_the_name_of_a_test_is_found():
    source = 'bears = 1  # soil is told anew\ndef test_soil_bears_it():\n    """`stripes`"""\n'
    assert refusedWords("\n".join(proseOf(source))) == ["anew", "bears"]


def test_control_a_refused_word_is_found_and_a_name_is_not():
    assert refusedWords("The run\nto trust bears it; `stripes` is a name.") == ["bears", "run to trust"]


def test_cpp_and_python_are_formatted():
    # scripts/test runs this in build/venv, where it has installed both: there nothing is skipped.
    missing = [tool.name for tool in FORMATTERS if not tool.exists()]
    if missing and Path(sys.prefix).resolve() != VENV.resolve():
        pytest.skip(f"no {' and no '.join(missing)} in build/venv; scripts/setup --test installs them")
    assert not missing, "scripts/setup --test did not install them"
    done = subprocess.run([ROOT / "scripts" / "format", "--check"], capture_output=True, text=True)
    assert done.returncode == 0, f"run scripts/format\n{done.stdout[-4000:]}{done.stderr[-4000:]}"
