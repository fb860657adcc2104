#!/usr/bin/python3
"""Does a test notice when a line that keeps people safe is gone? `make mutation`, docs/development.md.

Every row of the transition table and every `/* SAFETY:` mark of FILES is broken once, by the smallest change that its place allows, in a copy
of the sources; the tests of that file are built and run until one fails. Prints a table, status 1 when a mutant survives that EQUIVALENT does
not explain. The changes:

    a row of the table                     deleted
    a mark before a function               its body returns at once (0, false, NULL)
    a mark before a statement              the statement is deleted
    before a declaration with a value      the value is 0
    before `return`                        the opposite, or 0

OTHERWISE lists the places where these rules would be meaningless: the mark's first words, the text there, and its replacement.
"""

import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

from table import BY_MARK, EQUIVALENT, FILES, OTHERWISE, TESTS

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOKEN = re.compile(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\'|/\*.*?\*/', re.S)
MARK = re.compile(r"/\*(?:(?!\*/).)*?SAFETY:.*?\*/", re.S)
ROW = re.compile(r"^ *\{(STATE_\w+), (TRIGGER_\w+), STATE_\w+[^}\n]*\},\n", re.M)
HEAD = re.compile(r"(?:^static |^)([A-Za-z_][\w ]*?\**)(?<![\w])?\s*\b(\w+)\([^;{]*\)\s*\{", re.M)
HANG_S = 240  # a test that takes longer counts as hanging,
HANG_TIMES = 5  # unless this multiple of its usual time is longer


def blank(text):
    """Blanks comments and strings without changing the length, so that the remaining braces and semicolons are code."""
    return TOKEN.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)


def closing(code, at, pair):
    depth = 0
    for i in range(at, len(code)):
        depth += (code[i] == pair[0]) - (code[i] == pair[1])
        if not depth:
            return i + 1
    raise ValueError("unbalanced")


def statement_end(code, at):
    """Returns the end of the statement that begins here."""
    at += len(code[at:]) - len(code[at:].lstrip())
    if code[at] == "{":
        return closing(code, at, "{}")
    if match := re.compile(r"(if|while|for|switch)\b\s*").match(code, at):
        end = statement_end(code, closing(code, match.end(), "()"))
        other = re.compile(r"\s*else\b").match(code, end)
        return statement_end(code, other.end()) if match[1] == "if" and other else end
    if match := re.compile(r"do\b").match(code, at):
        return code.index(";", statement_end(code, match.end())) + 1
    depth = 0
    for i in range(at, len(code)):
        depth += (code[i] in "({[") - (code[i] in ")}]")
        if code[i] == ";" and not depth:
            return i + 1
    raise ValueError("no end of a statement")


def nothing(result):
    if result == "void":
        return "return;"
    return "return NULL;" if "*" in result else "return false;" if result == "bool" else "return 0;"


def enclosing(code, at):
    """Returns the return type of the enclosing function."""
    found = [match for match in HEAD.finditer(code) if match.start() < at]
    return found[-1][1].replace("static", "").strip() if found else "void"


def broken(text, code, mark):
    """Returns (description of the change, text without the marked code), by the rules above."""
    line = text.rfind("\n", 0, mark.start()) + 1
    before = code[line : mark.start()].strip()
    if before:  # the mark follows its statement, or a value of a list
        end = mark.start()
        begin = max(code.rfind(";", 0, code.rindex(";", 0, end)), code.rfind("{", 0, end), code.rfind("}", 0, end)) + 1
        return f"deleted: {before}", text[:begin] + ";" + text[end:]
    at = mark.end() + len(code[mark.end() :]) - len(code[mark.end() :].lstrip())
    head = HEAD.match(code, at)
    if head:
        result = head[1].replace("static", "").strip()
        return f"{head[2]}() does nothing", text[: head.end()] + " " + nothing(result) + text[head.end() :]
    end = statement_end(code, at)
    said = " ".join(text[at:end].split())
    if match := re.compile(r"return\b(.*);", re.S).match(text[at:end]):
        value = f"!({match[1]})" if enclosing(code, at) == "bool" else "0"
        return f"the opposite: {said}", text[:at] + f"return {value};" + text[end:]
    if match := re.compile(r"((?:const |static |struct )*[a-z]\w*[\s*]+\w+\s*=)[^=].*;", re.S).match(text[at:end]):
        return f"0 instead: {said}", text[:at] + match[1] + " 0;" + text[end:]
    return f"deleted: {said}", text[:at] + ";" + text[end:]


def said_by(text, mark):
    """Yields (text, line) for each SAFETY: of a comment."""
    for at in re.finditer("SAFETY:", mark[0]):
        words = mark[0][at.end() :].split("SAFETY:")[0].rstrip("*/ \n")
        yield re.sub(r"\s+\*?\s*", " ", words).strip(), text.count("\n", 0, mark.start() + at.start()) + 1


def mutants(root):
    """Yields (file, line, text of the mark, description of the change, changed text of the file)."""
    used = set()
    for file in sorted(name for pattern in FILES for name in map(str, root.glob(pattern))):
        text = pathlib.Path(file).read_text(encoding="utf-8")
        name, code = str(pathlib.Path(file).relative_to(root)), blank(text)
        for row in ROW.finditer(text):
            yield name, text.count("\n", 0, row.start()) + 1, f"{row[1]}, {row[2]}", "row deleted", text[: row.start()] + text[row.end() :]
        for mark, says, line in ((mark, says, line) for mark in MARK.finditer(text) for says, line in said_by(text, mark)):
            own = [entry for entry in OTHERWISE if entry[0] == name and says.startswith(entry[1])]
            for entry in own:
                used.add(entry)
                at = text.find(entry[2], mark.start())
                if at < 0:
                    yield name, line, says, f"table.py is behind the code: there is no {entry[2]!r}", None
                    continue
                yield name, line, says, f"{' '.join(entry[2].split())} -> {entry[3]}", text[:at] + entry[3] + text[at + len(entry[2]) :]
            if not own:
                try:
                    yield name, line, says, *broken(text, code, mark)
                except (ValueError, IndexError) as error:
                    sys.exit(f"tests/mutation/table.py: {name}:{line}: {says}: no rule for it ({error}); it needs a line in OTHERWISE")
    if stale := [entry for entry in OTHERWISE if entry not in used]:
        for name, says, *_ in stale:
            yield name, 0, says, "table.py is behind the code: there is no such mark", None


class Tree:
    """A copy of the sources with a build of its own."""

    def __init__(self, root):
        self.root = root
        root.mkdir(parents=True, exist_ok=True)
        files = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\0")
        for name in filter(None, files):
            to, source = root / name, ROOT / name
            to.parent.mkdir(parents=True, exist_ok=True)
            if not source.is_symlink() and source.exists() and not (to.exists() and to.read_bytes() == source.read_bytes()):
                shutil.copy2(source, to)
        self.environment = {**os.environ, "BUILD": "build", "CMOCKA_MESSAGE_OUTPUT": "TAP", "CCACHE_BASEDIR": str(root), "CCACHE_NOHASHDIR": "1"}
        self.environment.pop("MAKEFLAGS", None)
        self.environment.pop("MAKELEVEL", None)
        self.took_s = {}  # seconds that each test takes without any change

    def make(self, targets, flags=()):
        ccache = "ccache " if shutil.which("ccache") else ""
        command = ["make", "-j1", f"CC={ccache}gcc", f"CXX={ccache}g++", f"VENV={os.environ.get('VENV', ROOT / 'build/venv')}"]
        return subprocess.run([*command, *flags, targets], cwd=self.root, env=self.environment, capture_output=True, text=True, check=False)

    def test(self, test, flags=()):
        """Runs a test. Returns None if it passed, else the kind of failure. A scenario needs the program, a C test only itself. flags: for
        the recompiled parts."""
        script = test.endswith(".sh")
        built = self.make("build/hexid" if script else f"build/tests/{test}", flags)
        if built.returncode:
            return "does not compile: " + built.stderr.strip().split("\n")[0][:200]
        command, begun = [f"tests/scenarios/{test}"] if script else [f"build/tests/{test}"], time.monotonic()
        hang_s = max(HANG_S, HANG_TIMES * self.took_s.get(test, HANG_S))
        try:
            run = subprocess.run(command, cwd=self.root, env=self.environment, capture_output=True, text=True, timeout=hang_s, check=False,
                                 stdin=subprocess.DEVNULL, errors="replace")
        except subprocess.TimeoutExpired:
            return f"hangs for {hang_s:.0f} s"
        self.took_s.setdefault(test, time.monotonic() - begun)
        failed = re.findall(r"^not ok (?:\d+ )?(?:- )?(.*)$", run.stdout, re.M)
        if failed:
            return failed[0].strip()
        return f"ended with status {run.returncode}" if run.returncode else None


def kill(tree, name, text, tests):
    """Returns the test that fails, and how; None if the mutant survives."""
    path = tree.root / name
    whole = path.read_text(encoding="utf-8")
    path.write_text(text, encoding="utf-8")
    try:
        for test in tests:
            if how := tree.test(test, ("WARN=-w", "OPT=-O1")): # no warnings, because a mutant may have unused variables
                return test, how
    finally:
        path.write_text(whole, encoding="utf-8")
    return None


def tests_of(name, says):
    own = [tests for file, mark, tests in BY_MARK if file == name and says.startswith(mark)]
    return own[0] if own else next(tests for pattern, tests in TESTS if pathlib.PurePath(name).match(pattern))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--tree", type=pathlib.Path, default=ROOT / "build/mutation", help="where the copy is built")
    parser.add_argument("--only", default="", help="files or marks with this text")
    parser.add_argument("--list", action="store_true", help="what would be done")
    parser.add_argument("--stale", action="store_true", help="entries of table.py that the code has left behind")
    parser.add_argument("--minutes", type=float, default=60.0, help="begin no mutant after so many")
    options = parser.parse_args()

    chosen = [m for m in mutants(ROOT) if options.only in f"{m[0]}:{m[1]} {m[2]}"]
    if options.list:
        for name, line, says, done, _ in chosen:
            print(f"{name}:{line}  {says[:60]}\n    {done[:150]}")
        print(len(chosen))
        return
    if options.stale:
        sys.exit("\n".join(f"{name}:{line} {says[:60]}: {done}" for name, line, says, done, text in chosen if not text) or 0)
    tree, begun, survived, caught = Tree(options.tree.resolve()), time.monotonic(), 0, 0
    for test in sorted({test for name, _, says, *_ in chosen for test in tests_of(name, says)}):
        if how := tree.test(test):
            sys.exit(f"{test} fails without any change: {how}")
    print("| line | what is kept safe | mutation | caught by |\n| --- | --- | --- | --- |", flush=True)
    for name, line, says, done, text in chosen:
        if time.monotonic() - begun > 60 * options.minutes:
            sys.exit(f"not all of them within {options.minutes:g} minutes")
        killed = kill(tree, name, text, tests_of(name, says)) if text else None
        built = not killed or not killed[1].startswith("does not compile")
        reason = next((why for file, mark, why in EQUIVALENT if file == name and says.startswith(mark)), None)
        survived += not built or not (killed or reason)
        caught += bool(killed) and built
        verdict = f"`{killed[0]}`: {killed[1]}" if killed else f"redundant: {reason}" if reason else "**SURVIVED**"
        print(f"| {name}:{line} | {says[:90]} | {done[:110].replace('|', '&#124;')} | {verdict[:110]} |", flush=True)
    print(f"\n{len(chosen)} mutants, {caught} caught, {survived} survived, {len(chosen) - caught - survived} redundant, "
          f"{(time.monotonic() - begun) / 60:.0f} min")
    sys.exit(survived > 0)


if __name__ == "__main__":
    main()
