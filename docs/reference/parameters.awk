# The members of structs of parameters as Markdown tables: name, unit, default and what the comment says.
#
#   awk -v names="GroundSlip" -f parameters.awk HEADER.hpp ...
#
# Of the headers given: structs whose name ends on Options, Parameters, Params or Noise, and those in `names`.

function is_listed(name) {
  return name ~ /(Options|Parameters|Params|Noise)$/ || index(" " names " ", " " name " ")
}
# From the end of a name, else from the type.
function unit(name, type) {
  if (name ~ /_per_rad$|^translation_per_m$/) return ""
  if (match(name, /_per_m_rad$/)) return "rad/m"
  if (match(name, /_per_rad_m$/)) return "m/rad"
  if (match(name, /_(m_s2|mps2)$/)) return "m/s²"
  if (match(name, /_(m_s|mps)$/)) return "m/s"
  if (match(name, /_(rad_s|radps)$/)) return "rad/s"
  if (match(name, /_rad_s2$/)) return "rad/s²"
  if (match(name, /_m_per_sqrt_m$/)) return "√m"
  if (match(name, /_m_per_sqrt_s$/)) return "m/√s"
  if (match(name, /_mps_per_sqrt_s$/)) return "m/s/√s"
  if (match(name, /_rad_per_sqrt_s$/)) return "rad/√s"
  if (match(name, /_rad_per_sqrt_rad$/)) return "√rad"
  if (match(name, /_m2$/)) return "m²"
  if (match(name, /_(per_m2|per_m|per_s)$/)) return "1/" substr(name, RSTART + 5)
  if (match(name, /_(Pa|m|s|ms|rad|nats|bytes)$/)) return substr(name, RSTART + 1)
  if (name ~ /_uT$/) return "µT"
  if (name ~ /_us$/) return "µs"
  if (name ~ /_deg$/) return "°"
  if (name ~ /_hz$/) return "Hz"
  if (name ~ /_ghz$/) return "GHz"
  if (match(name, /_dbhz$/)) return "dB-Hz"
  if (match(name, /_db$/)) return "dB"
  if (match(name, /_ned_m2$/)) return "m²"
  if (type == "Angle") return "angle"
  if (type == "Duration") return "time"
  return ""
}
# A number of nanoseconds as seconds.
function seconds(text) {
  gsub(/'/, "", text)
  return text / 1e9 " s"
}
function value(text, type) {
  if (text == "" || text == "{}")
    return type ~ /^(bool|int|double|float)$/ ? "" : type ~ /^std::(function|vector|optional|string|map)/ ? "empty" \
           : type == "Angle" ? "0°" : type
  gsub(/std::chrono::/, "", text)
  gsub(/Eigen::/, "", text)
  gsub(/std::numeric_limits<double>::/, "", text)
  if (match(text, /^Angle::degrees\([-0-9.]+\)$/)) return substr(text, 16, RLENGTH - 16) "°"
  if (match(text, /^(milliseconds|seconds|hours)\([0-9]+\)$/)) {
    sub(/\)$/, text ~ /^m/ ? " ms" : text ~ /^h/ ? " h" : " s", text)
    sub(/^.*\(/, "", text)
    return text
  }
  if (type == "Duration" && match(text, /^\{[0-9']+\}$/)) return seconds(substr(text, 2, RLENGTH - 2))
  gsub(/ \* kDegree/, "°", text)
  gsub(/Angle::degrees\(/, "degrees(", text)
  return text
}
# Text that a cell of a table can hold.
function cell(text) {
  gsub(/&/, "\\&amp;", text)
  gsub(/</, "\\&lt;", text)
  gsub(/>/, "\\&gt;", text)
  gsub(/\|/, "\\&#124;", text)
  gsub(/\*/, "\\&#42;", text)
  return text
}
function code(text) { return text == "" ? "" : "<tt>" cell(text) "</tt>" }

# One member of a declaration: `name` or `name = default` or `name{default}`.
function member(type, text, comment,   name, given) {
  sub(/^ +/, "", text)
  match(text, /^[A-Za-z_0-9]+/)
  name = substr(text, 1, RLENGTH)
  given = substr(text, RLENGTH + 1)
  sub(/^ *= */, "", given)
  row("<tt>" name "</tt>", unit(name, type), code(value(given, type)), comment)
}
function row(name, in_unit, given, comment) {
  if (!rows++) {
    print "\n### " of " {#parameters_" of "}\n\n" about " See @ref " space "::" of " \"" of "\".\n"
    print "| parameter | unit | default | effect |\n|---|---|---|---|"
  }
  print "| " name " | " in_unit " | " given " | " cell(comment) " |"
}
# A whole declaration, without its comments.
function declaration(text, comment,   type) {
  sub(/;$/, "", text)
  if (text ~ /^ *(using|static|friend|enum|struct|\[\[)/ || text ~ /operator/) return
  if (match(text, /^ *[A-Za-z_:0-9]+(<[^=;]*>)?[&*]? /) == 0) return
  type = substr(text, 1, RLENGTH - 1)
  sub(/^ +/, "", type)
  text = substr(text, RLENGTH + 1)
  if (text ~ /^[A-Za-z_0-9]+\(/) return  # a function
  member(type, text, comment)
}

FNR == 1 { inside = nested = 0; about = "" }
/^namespace wayfare/ { space = $2 }
!inside && /^\/\/\/ / { about = about (about == "" ? "" : " ") substr($0, 5); next }
!inside && /^(template|requires)/ { next }
!inside && /^struct [A-Za-z0-9]+( : .*)? \{$/ && is_listed($2) {
  inside = 1
  of = $2
  rows = 0
  open = type = comment = ""
  next
}
!inside { about = ""; next }
/^\};/ { inside = 0; about = ""; next }
/^ private:/ { inside = 0; next }
/^  (struct|class|enum) .*\{$/ { nested = 1 }
nested { if (/^  \};/) { nested = 0; comment = "" } next }
/^    / && open == "" && !/\/\/\/</ { next }  # inside a function
/^  \/\/ / { next }
/^  \/\/\/ / { comment = comment (comment == "" ? "" : " ") substr($0, 7); next }
/^ *$/ { if (open == "") comment = ""; next }
{
  line = $0
  trailing = ""
  if (match(line, / *\/\/\/< /)) {
    trailing = substr(line, RSTART + RLENGTH)
    line = substr(line, 1, RSTART - 1)
  }
  if (open == "" && line ~ /[({]$/ && line !~ /=|\{$/) next
  sub(/^ +/, open == "" ? "" : " ", line)
  open = open line
  if (trailing != "") comment = comment (comment == "" ? "" : " ") trailing
  if (line ~ /;$/ || (line ~ /,$/ && trailing != "")) {
    text = open
    if (continued != "" && open !~ /^[A-Za-z_:0-9]+(<.*>)? [A-Za-z_]/) text = continued " " open
    ends = line ~ /,$/
    sub(/,$/, ";", text)
    if (ends && continued == "") { match(text, /^[A-Za-z_:0-9]+(<[^=;]*>)?/); continued = substr(text, 1, RLENGTH) }
    declaration(text, comment)
    if (!ends) continued = ""
    open = comment = ""
  } else if (line ~ /[{}]$/) {
    open = comment = ""
  }
}
