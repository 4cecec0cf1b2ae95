#pragma once

// Private: the style of plots, alone and in reports.

#include <cstddef>
#include <string>

#include <wayfare/io/report.hpp>

namespace wayfare::io {

/// Eight colours of curves, s0 to s7, for a light background.
inline constexpr const char* kPlotStyle = R"(
:root{--ink:#1c2126;--muted:#5d6770;--rule:#e1e5e9;
--c0:#2563c9;--c1:#d9480f;--c2:#2b8a3e;--c3:#862e9c;--c4:#0b7285;--c5:#946200;--c6:#c2255c;
--c7:#495057}
svg text{fill:var(--muted);font-size:12px;font-variant-numeric:tabular-nums}
svg .label{fill:var(--ink);font-size:13px}
svg path{fill:none;vector-effect:non-scaling-stroke;stroke-linejoin:round;stroke-linecap:round}
.grid{stroke:var(--rule)}.axis{stroke:var(--muted)}
.line,.dashed{stroke-width:1.7}.dashed{stroke-dasharray:6 5}.dots{stroke-width:5}
.s0{stroke:var(--c0)}.s1{stroke:var(--c1)}.s2{stroke:var(--c2)}.s3{stroke:var(--c3)}
.s4{stroke:var(--c4)}.s5{stroke:var(--c5)}.s6{stroke:var(--c6)}.s7{stroke:var(--c7)}
)";

/// Of the curve `index` of a plot.
inline std::string curve_class(Mark mark, std::size_t index) {
  std::string name("s");  // appended to: GCC 12 warns falsely of "s" + …
  name += std::to_string(index % 8);
  const bool dots = mark == Mark::points || mark == Mark::fine_points;
  name += dots ? " dots" : mark == Mark::dashed ? " dashed" : " line";
  return name;
}

/// A piece of it, 26 wide and 10 high.
inline std::string legend_sample(Mark mark, std::size_t index) {
  return "<path class=\"" + curve_class(mark, index) + "\" d=\"" +
         (mark == Mark::points || mark == Mark::fine_points ? "M5 5h0M13 5h0M21 5h0" : "M2 5H24") +
         "\"/>";
}

}  // namespace wayfare::io
