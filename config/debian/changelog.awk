# docs/changelog.md in the form of a Debian changelog. Variables: version, maintainer. A heading is "## VERSION, YYYY-MM-DD".
function stamp(day,    command, text) {
    command = "LC_ALL=C date -u -R -d " day
    command | getline text
    close(command)
    return text
}
function wrapped(text, first,    line, i, n, word) {
    n = split(text, word, " ")
    line = first word[1]
    for (i = 2; i <= n; i++)
        if (length(line " " word[i]) > 79) { print line; line = "    " word[i] } else line = line " " word[i]
    print line
}
function trailer() { if (day) printf "\n -- %s  %s\n\n", maintainer, stamp(day) }
/^## [0-9.]+, [0-9-]+$/ {
    trailer()
    number = $2
    sub(/,/, "", number)
    day = $3
    printf "hexid (%s) unstable; urgency=medium\n\n", number
    next
}
day && /^- / { wrapped(substr($0, 3), "  * "); next }
day && /^  [^ ]/ { wrapped(substr($0, 3), "    ") }
END { trailer() }
