# A manual page of what `hexid SUBCOMMAND --help` prints: synopsis up to the second line that does not begin with a blank, description,
# then "Options:", "Example:", and what else there is. Variables: name, version, date.
function escaped(line) {
    gsub(/\\/, "\\e", line)
    gsub(/-/, "\\-", line)
    return line ~ /^[.']/ ? "\\\\&" line : line
}
function section(title) { print ".SH " title; }
function item(line,    at) {
    at = match(substr(line, 3), / /) ? index(substr(line, 3) "  ", "  ") : length(line)
    print ".TP\n.B " escaped(substr(line, 3, at - 1))
    line = substr(line, at + 2)
    sub(/^ +/, "", line)
    if (line != "") print escaped(line)
}
NR == 1 { print ".TH " toupper(name) " 1 \"" date "\" \"hexid " version "\" \"User Commands\""; synopsis = $0; next }
!purpose && /^ / { sub(/^ +/, " "); synopsis = synopsis $0; next }
!purpose {
    purpose = $0
    section("NAME")
    print escaped(name " - " purpose)
    section("SYNOPSIS")
    print escaped(synopsis)
    section("DESCRIPTION")
    print escaped(toupper(substr(purpose, 1, 1)) substr(purpose, 2) ".")
    next
}
/^Options:$/ { section("OPTIONS"); part = "options"; next }
/^Example:$/ { section("EXAMPLE"); part = "example"; next }
/^$/ { if (part == "options") part = "more"; next }
part == "options" && /^  [^ ]/ { item($0); next }
part == "options" && / +(sim:|can:|modbus:|fault:)/ { sub(/^ +/, ""); print ".br\n" escaped($0); next }
part == "options" { sub(/^ +/, ""); print escaped($0); next }
part == "example" { sub(/^ +/, ""); print ".nf\n" escaped($0) "\n.fi"; next }
part == "more" { section("NOTES"); print escaped(toupper(substr($0, 1, 1)) substr($0, 2) "."); next }
END { section("SEE ALSO"); print ".BR hexid (1);\nthe pages under /usr/share/doc/hexid." }
