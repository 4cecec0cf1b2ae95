# awk -v recordings=0|1 -f script.awk PAGE.md: the page as a shell script, which run.sh completes and
# describes.
function quoted(text) {
  gsub(/'/, "'\\''", text)
  return "'" text "'"
}
/^ *```/ && !inside {
  inside = 1
  words = $0
  sub(/^ *```/, "", words)
  n = split(words, word, " ")
  kind = "prose"
  if (word[1] == "sh" && (n == 1 || (word[2] == "recordings" && recordings))) {
    kind = "commands"
    left_out = 0
    print "begin " NR
  } else if (word[1] == "sh") {
    left_out = 1
  } else if (word[1] == "text" && word[2] !~ /[.]/) {
    if (!left_out) {
      kind = "output"
      print "expect " NR " " (n == 2 ? word[2] : "2%") " <<'END_OF_BLOCK'"
    }
  } else if (n == 2) {
    kind = "file"
    print "cat >" quoted(word[2]) " <<'END_OF_BLOCK'"
  }
  next
}
/^ *```/ {
  inside = 0
  if (kind == "commands") print "end"
  if (kind == "output" || kind == "file") print "END_OF_BLOCK"
  next
}
inside && kind != "prose" { print }
