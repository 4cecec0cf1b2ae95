# awk -v tolerance=2 -f expect.awk EXPECTED OUTPUT: fails unless the lines of EXPECTED are those of OUTPUT.
# Words are equal, numbers equal to `tolerance` percent or to one in the last digit shown. `*` stands for
# any word, a line `…` for any number of lines; rulers of tables may be of any length.
function bare(word) {
  gsub(/[][(),;:%]/, "", word)
  return word
}
function same(shown, got,    unit, off) {
  shown = bare(shown)
  got = bare(got)
  if (shown == got || shown == "*" || (shown got) ~ /^--+$/) return 1
  if (shown !~ number || got !~ number) return 0
  unit = match(shown, /[.][0-9]+/) ? 10 ^ (1 - RLENGTH) : 1
  off = shown - got
  if (off < 0) off = -off
  return off <= 1.001 * unit || off <= tolerance / 100 * (shown < 0 ? -shown : shown)
}
function matches(shown, got,    i, n, m, a, b) {
  n = split(shown, a, " ")
  m = split(got, b, " ")
  for (i = 1; i <= n && n == m; ++i)
    if (!same(a[i], b[i])) return 0
  return n == m
}
BEGIN { number = "^[-+]?[0-9]+([.][0-9]+)?([eE][-+]?[0-9]+)?$" }
/^ *$/ { next }
NR == FNR {
  if ($0 == "…") any[lines + 1] = 1
  else expected[++lines] = $0
  next
}
at < lines && matches(expected[at + 1], $0) { ++at; next }
!any[at + 1] {
  print at < lines ? "shown: " expected[at + 1] : "not shown:"
  print "got:   " $0
  failed = 1
  exit
}
END {
  if (!failed && at < lines) print "shown: " expected[at + 1] "\ngot:   nothing like it"
  exit failed || at < lines
}
