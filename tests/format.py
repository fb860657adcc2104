#!/usr/bin/python3
"""The form of the C and C++: `make format-check` names the files that are not in it, with the difference; `make format` brings them there.

It also checks what clang-format does not: a comment ends at column 100, and a line, whose string no tool breaks, at column 140; calls
reserved for one file (threads, limits, waits) stand in no other; and at most 1 % of the comments begin with "Of", "What", "Where" or "That",
since nearly all of those lack a subject.
"""

import difflib
import pathlib
import re
import shutil
import subprocess
import sys

CLANG_FORMAT = "clang-format-22"
FOLDERS = "src", "include", "hal", "sim", "tests"
SUFFIXES = ".c", ".h", ".cpp", ".hpp"
COMMENT_END, LINE_END = 100, 140
FRAGMENT, FRAGMENTS_MOST = re.compile(r"(of|what|where|that)\b", re.I), 0.01

TOKEN = re.compile(
    r"""R"\((?:.|\n)*?\)"|"(?:\\(?:.|\n)|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'|(?P<comment>/\*(?:.|\n)*?\*/|//[^\n]*)"""
)


def too_wide(text):
    """Yields the lines on which a comment or the line itself ends too far to the right."""
    for comment in (match for match in TOKEN.finditer(text) if match["comment"]):
        line, column = text.count("\n", 0, comment.start()) + 1, comment.start() - (text.rfind("\n", 0, comment.start()) + 1)
        for i, part in enumerate(comment[0].split("\n")):
            if len(part) + (0 if i else column) > COMMENT_END:
                yield line + i, f"a comment passes column {COMMENT_END}"
    for i, line in enumerate(text.split("\n")):
        if len(line) > LINE_END:
            yield i + 1, f"the line passes column {LINE_END}"


# Calls that only certain files may contain: the pattern, the files, and the reason.
RESERVED = (
    (re.compile(r"\bpthread_create *\("), ("src/rt/thread.c",), "thread_start() states the size of the stack"),
    (re.compile(r"\b(setrlimit|umask) *\("), ("src/rt/process.c",), "the start of the process has one place"),
    (
        re.compile(r"\bCLOCK_REALTIME\b"),
        ("src/rt/clock.c", "src/cli/gap_files.c", "hal/can_socket.c"),
        "it jumps when it is set; for dates and the kernel's stamps only",
    ),
    (
        re.compile(r"\b(sem_timedwait|pthread_(cond_timedwait|mutex_timedlock|timedjoin_np)|mq_timed\w+|alarm|setitimer|gettimeofday) *\("),
        (),
        "it waits by a clock that jumps; sem_clockwait() and its like take CLOCK_MONOTONIC",
    ),
)
PROGRAM = "src/", "hal/", "sim/", "include/"


def reserved(file, text):
    """Yields the lines of the program with a call that is reserved for another file."""
    code = TOKEN.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
    for pattern, owners, why in RESERVED:
        if not file.startswith(PROGRAM) or file in owners:
            continue
        for match in pattern.finditer(code):
            yield code.count("\n", 0, match.start()) + 1, f"{match[0].strip('( ')}: {why}"


def fragments(texts):
    """Returns the comments that begin as fragments do, worst files first, or none while they are few enough; and their share of all."""
    found = {file: [] for file in texts}
    total = 0
    for file, text in texts.items():
        for match in TOKEN.finditer(text):
            words = " ".join(re.sub(r"\n\s*\*", " ", match["comment"] or "").strip("/*").split())
            total += bool(words)
            if FRAGMENT.match(words):
                found[file].append((text.count("\n", 0, match.start()) + 1, words))
    share = sum(map(len, found.values())) / total
    worst = sorted(found, key=lambda file: -len(found[file])) if share > FRAGMENTS_MOST else []
    return [f"{file}:{line}: a fragment? {words[:60]}" for file in worst for line, words in found[file]], share


def formatted_otherwise(files):
    """Returns the files that clang-format would change. It reports only the first such line of each file."""
    run = subprocess.run([CLANG_FORMAT, "--dry-run", "--ferror-limit=1", *files], capture_output=True, text=True, check=False)
    if run.returncode:
        sys.exit(run.stderr)
    return sorted(set(re.findall(r"^([^:\n]+):\d+:\d+: warning: code should be clang-formatted", run.stderr, re.M)))


def difference(file):
    formatted = subprocess.run([CLANG_FORMAT, file], capture_output=True, text=True, check=True).stdout
    old, new = pathlib.Path(file).read_text().splitlines(True), formatted.splitlines(True)
    return "".join(difflib.unified_diff(old, new, file, f"{file}, formatted"))


def main():
    if not shutil.which(CLANG_FORMAT):
        sys.exit(f"{CLANG_FORMAT} is not there: `make deps` installs it")
    files = sorted(str(p) for folder in FOLDERS for p in pathlib.Path(folder).rglob("*") if p.suffix in SUFFIXES)
    if sys.argv[1:] == ["apply"]:
        subprocess.run([CLANG_FORMAT, "-i", *files], check=True)
    texts = {file: pathlib.Path(file).read_text() for file in files}
    wide = [f"{file}:{line}: {what}" for file in files for line, what in too_wide(texts[file])]
    taken = [f"{file}:{line}: {what}" for file in files for line, what in reserved(file, texts[file])]
    unclear, share = fragments(texts)
    other = formatted_otherwise(files)
    for file in other:
        print(difference(file), end="")
    for line in [f"{file}: `make format` writes it otherwise" for file in other] + wide + taken + unclear:
        print(line)
    print(f"{'not ' if other else ''}ok - {len(files)} files are as {CLANG_FORMAT} writes them")
    print(f"{'not ' if wide else ''}ok - comments end at column {COMMENT_END}, lines at column {LINE_END}")
    print(f"{'not ' if taken else ''}ok - threads, limits and waits are those of their own files")
    print(f"{'not ' if unclear else ''}ok - {100 * share:.2f} % of the comments begin as fragments do, at most {100 * FRAGMENTS_MOST:g} % may")
    failed = sum(map(bool, (other, wide, taken, unclear)))
    print(f"{4 - failed} passed, {failed} failed")
    sys.exit(failed > 0)


main()
