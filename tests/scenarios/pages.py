"""The documentation, README.md and all *.md, read as its readers do. From the repository root.

    pages.py links            every link, anchor, file and page that a page or a source names is there, and each function of docs/code.md in its file;
                              README.md and the pictures are small
    pages.py messages         every message in the first column of docs/troubleshooting.md's tables is in a source, dots for what is filled in
    pages.py installed DIR    the same links of the pages installed there; what they tell a reader to type has no path of a checkout
    pages.py commands PAGE    the commands of a page: its blocks that begin with ```sh
    pages.py shown PAGE       what it says they print: its blocks that begin with ```text, without the lines of dots

A block that begins with "```sh by hand" is not run: its commands need a person, a machine, or minutes."""
import pathlib
import re
import sys

README_LINES = 150
PICTURES_BYTES = 300_000  # limit of their sum, because the repository keeps pictures for ever
SOURCES = "Makefile src hal sim include config lcmtypes tests docs .ci".split()
NAMED = re.compile(r"`((?:[\w.-]+/)+[\w.-]+\.(?:c|h|cpp|hpp|py|sh|md|yaml|dbc|eds|lcm|csv))\b")
OF_THE_CHECKOUT = ("install.md", "development.md", "extending.md")  # valid only in a checkout, also where they are installed
MADE = re.compile("(runs|build|stand|DIR)/|.*NAME")  # made by the commands of a page or by its reader
OF_A_SOURCE = re.compile(r"\bdocs/([\w-]+)\.md(?:,? (?:section )?(\d)\b|, ([A-Z][a-z]+(?: [a-z]+)*))?")


def outside_blocks(page):
    """Yields the numbered lines outside fenced blocks."""
    fenced = False
    for number, line in enumerate(page.read_text().split("\n"), 1):
        fence = line.startswith("```")
        fenced ^= fence
        if not fence and not fenced:
            yield number, line


def headings(page):
    return [line.lstrip("#").strip() for _, line in outside_blocks(page) if re.match("#+ ", line)]


def anchors(page):
    """Yields the anchors as GitHub makes them."""
    seen = {}
    for heading in headings(page):
        anchor = re.sub(r"[^\w\- ]", "", re.sub(r"[`*]", "", heading).lower()).replace(" ", "-")
        seen[anchor] = seen.get(anchor, -1) + 1
        yield anchor if not seen[anchor] else f"{anchor}-{seen[anchor]}"


def broken_links(page, checkout=True):
    for number, line in outside_blocks(page):
        for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "", line)):
            if re.match(r"\w+:", target):
                continue
            path, _, anchor = target.partition("#")
            file = page.parent / path if path else page
            if not file.exists():
                yield f"{page}:{number}: {target}: no such file"
            elif anchor and anchor not in anchors(file):
                yield f"{page}:{number}: {target}: no such heading"
        for path in NAMED.findall(line) if checkout else ():
            if not MADE.match(path) and not pathlib.Path(path).exists() and not (page.parent / path).exists():
                yield f"{page}:{number}: {path}: no such file"


def broken_names(source):
    """Yields references of a source to a page's section, by number or title, that do not exist: docs/method.md section 4; docs/safety.md,
    What can fail."""
    for page, section, title in OF_A_SOURCE.findall(source.read_text(errors="replace")):
        file = pathlib.Path("docs", page + ".md")
        if not file.exists():
            yield f"{source}: {file}: no such page"
        elif section and not any(h.startswith(section + ". ") for h in headings(file)):
            yield f"{source}: {file} section {section}: no such section"
        elif title and not any(title.startswith(h) or h.startswith(title) for h in headings(file)):
            yield f"{source}: {file}, {title}: no such heading"


def broken_functions(page):
    """Yields the functions whose definition is in no file that the same paragraph or list item names."""
    for part in re.split(r"\n\n|\n(?=\d+\. |- )", page.read_text()):
        files = [pathlib.Path(f) for f in re.findall(r"`((?:src|hal|sim|include)/[\w/.-]+\.[ch])`", part)]
        defined = "\n".join(f.read_text() for f in files if f.exists())
        for name in re.findall(r"`(\w+)\(\)`", part):
            if not re.search(rf"^[a-z].*\b{name}\(.*[{{,]$|^[a-z].*\b{name}\(.*\}}$", defined, re.M):
                yield f"{page}: {name}(): in none of the files that its paragraph names"


def links():
    pages = [p for p in pathlib.Path(".").rglob("*.md") if p.parts[0] not in ("build", "runs")]
    sources = [f for s in SOURCES for f in ([pathlib.Path(s)] if pathlib.Path(s).is_file() else pathlib.Path(s).rglob("*"))
               if f.is_file() and "__pycache__" not in f.parts]
    broken = [b for p in pages for b in broken_links(p)] + [b for s in sources for b in broken_names(s)]
    broken += broken_functions(pathlib.Path("docs/code.md"))
    listed = pathlib.Path("docs/README.md").read_text()
    broken += [f"docs/README.md: does not list {p.name}" for p in pages
               if p.parent == pathlib.Path("docs") and p.name != "README.md" and f"({p.name})" not in listed]
    lines = len(pathlib.Path("README.md").read_text().splitlines())
    if lines > README_LINES:
        broken.append(f"README.md: {lines} lines, at most {README_LINES}")
    drawn = sum(p.stat().st_size for p in pathlib.Path("docs/pictures").glob("*.*g"))
    if drawn > PICTURES_BYTES:
        broken.append(f"docs/pictures: {drawn} bytes, at most {PICTURES_BYTES}")
    print("\n".join(broken) or f"{len(pages)} pages, {len(sources)} sources")
    return bool(broken)


def installed(tree):
    pages = list(pathlib.Path(tree).rglob("*.md"))
    broken = [b for p in pages for b in broken_links(p, checkout=False)]
    broken += [f"{p}:{number}: {line}" for p in pages if p.name not in OF_THE_CHECKOUT
               for number, line in enumerate(p.read_text().split("\n"), 1) if re.search(r"build/hexid|(?<![/\w])config/", line)]
    print("\n".join(broken) or f"{len(pages)} pages")
    return bool(broken) or len(pages) < 20


def messages():
    sources = [p for pattern in ("Makefile", "src/*/*.c", "hal/*.c", "sim/*.c") for p in pathlib.Path(".").glob(pattern)]
    text = re.sub(r'"\s*\n\s*"', "", "\n".join(p.read_text() for p in sources))  # a literal over several lines is one
    rows = [line for line in pathlib.Path("docs/troubleshooting.md").read_text().split("\n") if line.startswith("| `")]
    parts = [part.strip() for row in rows for message in re.findall("`([^`]+)`", row.split(" | ")[0]) for part in message.split("...")]
    unknown = [part for part in parts if part and part not in text]
    print("\n".join(unknown) or f"{len(rows)} messages")
    return bool(unknown) or len(rows) < 20


def blocks(path, kind):
    found = re.findall(rf"^```{kind}\n(.*?)^```$", pathlib.Path(path).read_text(), re.M | re.S)
    print("".join(line + "\n" for block in found for line in block.splitlines() if line.strip() != "..."), end="")
    return not found


if __name__ == "__main__":
    command, *rest = sys.argv[1:]
    if command in ("links", "messages"):
        sys.exit(links() if command == "links" else messages())
    if command == "installed":
        sys.exit(installed(*rest))
    sys.exit(blocks(rest[0], {"commands": "sh", "shown": "text"}[command]))
