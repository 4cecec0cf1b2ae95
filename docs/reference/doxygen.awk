# Doxygen's filter for Markdown (awk -f doxygen.awk FILE.md): headings get labels, formed as GitHub forms its
# anchors, links to anchors lead to them, and the programs of the tour that a page names are shown at its end.
# Comments that stand alone on a line are replaced, so that what they stand for is written once:
#   <!-- family: NAME -->              the component, from components.md
#   <!-- headers: NAME -->             its headers, with the first sentence of each
#   <!-- parameters: NAME STRUCT… -->  tables of the parameters in the headers, by parameters.awk
#   <!-- snippet: FILE MARK -->        the lines between //! [MARK] in tests/FILE
# A line in italics that says where these are otherwise, *… (`./run docs`).*, is left out.

# The page's part of a label: the file, or "FOLDER_README".
function page(path,   parts, n) {
  sub(/\.md$/, "", path)
  n = split(path, parts, "/")
  if (n > 1 && parts[n - 1] == "families") return "family_" parts[n]
  return parts[n] == "README" && n > 1 ? parts[n - 1] "_README" : parts[n]
}
function label(path, heading) {
  heading = tolower(heading)
  gsub(/[^a-z0-9 _-]/, "", heading)
  gsub(/ /, "-", heading)
  return "at_" page(path) "_" heading
}
# Where a link leads, which is not the file's name alone.
function target(link,   hash, file) {
  hash = index(link, "#")
  if (hash == 0) return "@ref " label(FILENAME, link)
  file = hash == 1 ? FILENAME : substr(link, 1, hash - 1)
  if (file !~ /\//) file = substr(FILENAME, 1, match(FILENAME, /[^\/]*$/) - 1) file
  return "@ref " label(file, substr(link, hash + 1))
}
function show(program) {
  if (!(program in shown)) programs[++count] = program
  shown[program] = 1
}

# The first sentence of the comment at the beginning of a header.
function about(header,   line, text, n) {
  while ((getline line < header) > 0 && line !~ /^#include/)
    if (line ~ /^\/\/ / && text !~ /[.:]$/) {
      n = match(line, /[.:] [A-Z]|[.:]$/)
      text = text substr(line, 3, n ? n - 2 : length(line))
    }
  close(header)
  gsub(/</, "\\&lt;", text)
  gsub(/\|/, "\\&#124;", text)
  sub(/:$/, ".", text)
  return text
}
# Of components.md: the row of a family, and the headers of its section.
function family(name, with_headers,   list, line, cells, inside) {
  list = "docs/reference/components.md"
  print with_headers ? "| header | content |\n|---|---|" : "| | |\n|---|---|\n| all headers | `<wayfare/" name ".hpp>` |"
  while ((getline line < list) > 0) {
    if (!with_headers && line ~ "^\\| \\[`" name "`\\]") {
      split(line, cells, / *\| */)
      print "| component | `wayfare::" name "`, " cells[3] " |"
      print "| uses | " (cells[4] == "" ? "Eigen alone" : cells[4]) " |"
      if (cells[5] != "") print "| needs (Debian) | " cells[5] " |"
    }
    if (line ~ /^## /) inside = line == "## " name
    if (with_headers && inside && match(line, /`wayfare\/[a-z_0-9\/]+[.]hpp`/)) {
      line = substr(line, RSTART + 1, RLENGTH - 2)
      print "| " line " |" about("include/" line) " |"
    }
  }
  close(list)
}
function run(command,   line) {
  while ((command | getline line) > 0) print line
  close(command)
}

# Names in the tables of a family's page lead to what they name, which must exist.
function linked(line,   space, before, name, out) {
  space = page(FILENAME)
  sub(/^family_/, "", space)
  space = "wayfare::" (space ~ /^(decode|eval|io|logger|ros|sim|testing)$/ ? space "::" : "")
  while (match(line, /`[A-Za-z_][A-Za-z_0-9]*(::[A-Za-z_]+)*`/)) {
    before = substr(line, 1, RSTART - 1)
    name = substr(line, RSTART + 1, RLENGTH - 2)
    line = substr(line, RSTART + RLENGTH)
    out = out before (name ~ /^wayfare::/ || before ~ /program $/ ? "`" name "`" \
                                                                  : "@ref " space name " \"" name "\"")
  }
  return out line
}

/^```/ { in_code = !in_code }
!in_code && /^[*].*`[.]\/run docs`[)][.][*]$/ { next }
!in_code && /^<!-- (family|headers): [a-z]+ -->$/ { family($3, $2 == "headers:"); next }
!in_code && /^<!-- parameters: [a-z]+( [A-Za-z0-9]+)* -->$/ {
  structs = $0
  gsub(/^<!-- parameters: [a-z]+ *| *-->$/, "", structs)
  print "## Parameters {#" label(FILENAME, "parameters") "}"
  run("awk -v names='" structs "' -f docs/reference/parameters.awk include/wayfare/" $3 "/*.hpp include/wayfare/" $3 "/detail/*.hpp 2>/dev/null")
  next
}
!in_code && /^<!-- snippet: [a-z_\/]+[.][ch]pp [a-z ]+ -->$/ {
  mark = $0
  gsub(/^<!-- snippet: [^ ]+ | -->$/, "", mark)
  print "@snippet " $3 " " mark
  next
}
!in_code && /^##+ / {
  heading = $0
  sub(/^#+ /, "", heading)
  $0 = $0 " {#" label(FILENAME, heading) "}"
}
!in_code {
  line = $0
  $0 = ""
  while (match(line, /\]\(([^)#:]*#[^)]*|[0-9a-z_]+\.cpp)\)/)) {
    link = substr(line, RSTART + 2, RLENGTH - 3)
    $0 = $0 substr(line, 1, RSTART + 1)
    line = substr(line, RSTART + RLENGTH)
    if (link ~ /\.cpp$/) show(link)
    $0 = $0 target(link) ")"
  }
  $0 = $0 line
}
!in_code && FILENAME ~ /reference\/families\// && /^\|/ { $0 = linked($0) }
!in_code && FILENAME ~ /docs\/reference\// {
  line = $0
  while (match(line, /examples\/tour\/[0-9a-z_]+\.cpp/)) {
    show(substr(line, RSTART + 14, RLENGTH - 14))
    line = substr(line, RSTART + RLENGTH)
  }
}
{ print }
END {
  for (i = 1; i <= count; ++i)
    print "\n## " programs[i] " {#" label(FILENAME, programs[i]) "}\n\n@include " programs[i]
}
