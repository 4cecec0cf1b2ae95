# Doxygen's filter for headers (awk -f headers.awk FILE.hpp), line by line, so that warnings name their lines.

# Headers in detail/ are not part of the API; shown are types that options and results are made of.
BEGIN {
  shown = "bytes mt_values external_heading descriptor copy_on_write_tiles padded_table precomputation_grids" \
          " scene_constraint corridor_motion foot_filter magnetic_heading_drift mean_field_north straight_walk" \
          " walking_heading node_output raw_node smooth_curve carrier_filter law_inputs"
}
FNR == 1 && FILENAME ~ /\/detail\// {
  header = FILENAME
  gsub(/^.*\/|[.]hpp$/, "", header)
  if (!index(" " shown " ", " " header " ")) exit
}

# The comment at the beginning of a header, before which a line is empty, documents the file.
FNR == 2 && /^$/ { print "/// @file"; heads = 1; next }
heads && FNR == 3 && !/^\/\// { heads = 0 }
heads && /^\/\/   / {  # an example
  print "///     " substr($0, 3)
  next
}
heads && /^\/\// {
  gsub(/\\/, "\\\\")
  gsub(/</, "\\&lt;")
  gsub(/>/, "\\&gt;")
  print "/" $0
  next
}
{ heads = 0 }
# What all ROS messages have.
FILENAME ~ /\/ros\/message(s|_parts)[.]hpp$/ && /^  static constexpr MessageType kType/ {
  printf "/** Published name, MD5 sum and constants. */"
}
FILENAME ~ /\/ros\/message(s|_parts)[.]hpp$/ && /^  static void fields\(/ {
  printf "/** Calls `a(name, field)` for each field, in the order of the definition. */"
}
{ print }
