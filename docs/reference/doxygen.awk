# Doxygen's filter for Markdown (awk -f doxygen.awk FILE.md): headings get labels, formed as GitHub forms its
# anchors, links to anchors lead to them, and the programs of the tour that a page names are shown at its end.

# The page's part of a label: the file, or "FOLDER_README".
function page(path,   parts, n) {
  sub(/\.md$/, "", path)
  n = split(path, parts, "/")
  return parts[n] == "README" && n > 1 ? parts[n - 1] "_README" : parts[n]
}
function label(path, heading) {
  heading = tolower(heading)
  gsub(/[^a-z0-9 _-]/, "", heading)
  gsub(/ /, "-", heading)
  return "at_" page(path) "_" heading
}
# Where a link leads, which is not the file's name alone.
function target(link,   hash) {
  hash = index(link, "#")
  if (hash == 0) return "@ref " label(FILENAME, link)
  return "@ref " label(hash == 1 ? FILENAME : substr(link, 1, hash - 1), substr(link, hash + 1))
}
function show(program) {
  if (!(program in shown)) programs[++count] = program
  shown[program] = 1
}

/^```/ { in_code = !in_code }
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
    if (link ~ /\.cpp$/) show(link)
    $0 = $0 substr(line, 1, RSTART + 1) target(link) ")"
    line = substr(line, RSTART + RLENGTH)
  }
  $0 = $0 line
}
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
