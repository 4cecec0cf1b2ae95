#include <wayfare/io/report.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "io/picture/plot_style.hpp"
#include "io/picture/report_json.hpp"
#include "io/text/text.hpp"
#include "io/text/utf8.hpp"

namespace wayfare::io {
namespace {

constexpr const char* kStyle = R"(
:root{color-scheme:light dark;--page:#f6f7f8;--card:#fff}
@media(prefers-color-scheme:dark){:root{--page:#14171a;--card:#1d2125;--ink:#e6e9ec;
--muted:#9aa5af;--rule:#32383e;--c0:#6ea8fe;--c1:#ff922b;--c2:#69db7c;--c3:#da77f2;--c4:#3bc9db;
--c5:#fcc419;--c6:#f783ac;--c7:#ced4da}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);font:15px/1.5 system-ui,-apple-system,
"Segoe UI",Roboto,"DejaVu Sans",sans-serif}
main{max-width:960px;margin:0 auto;padding:32px 20px 64px}
h1{font-size:26px;line-height:1.2;margin:0 0 4px}
h2{font-size:18px;margin:36px 0 12px}
p{margin:8px 0;max-width:75ch}
.subtitle{color:var(--muted);margin:0 0 20px}
.facts{display:grid;grid-template-columns:repeat(auto-fill,minmax(165px,1fr));gap:10px;
margin:16px 0}
.facts div{background:var(--card);border:1px solid var(--rule);border-radius:8px;
padding:10px 14px}
.facts dt{color:var(--muted);font-size:12.5px}
.facts dd{margin:2px 0 0;font-size:18px;font-weight:600;font-variant-numeric:tabular-nums;
overflow-wrap:anywhere}
figure{background:var(--card);border:1px solid var(--rule);border-radius:8px;margin:16px 0;
padding:14px 16px;overflow-x:auto}
figcaption{font-weight:600;margin-bottom:8px}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
th,td{padding:6px 8px;text-align:right;border-bottom:1px solid var(--rule);white-space:nowrap}
th:first-child,td:first-child{text-align:left;padding-left:2px;white-space:normal}
thead th{color:var(--muted);font-weight:600;font-size:13px}
tbody tr:last-child td{border-bottom:0}
.unit{font-weight:400}
.legend{display:flex;flex-wrap:wrap;gap:4px 18px;font-size:13px;color:var(--muted);
margin:0 0 6px}
.legend svg{width:26px;height:10px;display:inline-block;margin-right:6px;vertical-align:middle}
svg{display:block;width:100%;height:auto}
img{display:block;min-width:min(100%,620px);max-width:100%;max-height:900px;margin:0 auto}
@media print{body{background:#fff}figure,.facts div{break-inside:avoid}}
)";

constexpr const char* kDoubtStyle = R"(
.doubt{background:#fff3bf;color:#5c3c00;border:2px solid #f08c00;border-radius:8px;margin:16px 0;
padding:10px 14px;overflow-wrap:anywhere}
)";

std::string element(const char* tag, const std::string& text) {
  return std::string("<") + tag + ">" + escape_html(text) + "</" + tag + ">\n";
}

std::string legend(const Plot& plot) {
  if (plot.series.size() < 2) return {};
  std::string out = "<div class=\"legend\">";
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    out += "<span><svg viewBox=\"0 0 26 10\" aria-hidden=\"true\">";
    out += legend_sample(plot.series[i].mark, i);
    out += "</svg>" + escape_html(plot.series[i].name) + "</span>";
  }
  return out + "</div>\n";
}

}  // namespace

std::string escape_html(std::string_view text) {
  constexpr std::string_view kSpecial = "&<>\"'";
  constexpr const char* kEntities[] = {"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"};
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = text::utf8_length(text);
    const char c = text.front();
    const bool control = static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t';
    if (length == 0 || control || c == 0x7f) {
      out += "\ufffd";
    } else if (const std::size_t i = kSpecial.find(c); i != kSpecial.npos) {
      out += kEntities[i];
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out;
}

Series path_series(std::string name, const Trajectory& trajectory, const SE2d& T, Mark mark) {
  Series series{std::move(name), {}, {}, mark};
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector2d p = T * pose.T_map_base.raw().translation();
    series.add(p.x(), p.y());
  }
  return series;
}

Series broken_at_wraps(const Series& series) {
  Series broken{series.name, {}, {}, series.mark};
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    if (i > 0 && std::abs(series.y[i] - series.y[i - 1]) > 180.0)
      broken.add(series.x[i], std::numeric_limits<double>::quiet_NaN());
    broken.add(series.x[i], series.y[i]);
  }
  return broken;
}

PlotImage plot_image(const GridImage& grid) {
  const double width_m = static_cast<double>(grid.width) * grid.resolution_m;
  const double height_m = static_cast<double>(grid.height) * grid.resolution_m;
  return {to_picture(grid), grid.origin.x(), grid.origin.x() + width_m, grid.origin.y(),
          grid.origin.y() + height_m};
}

Series bounds_series(const Series& upper) {
  Series bounds = upper;
  bounds.mark = Mark::dashed;
  if (upper.x.empty()) return bounds;
  bounds.add(upper.x.back(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < std::min(upper.x.size(), upper.y.size()); ++i)
    bounds.add(upper.x[i], -upper.y[i]);
  return bounds;
}

Report::Report(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

Report& Report::heading(const std::string& text) {
  body_ += element("h2", text);
  blocks_.emplace_back(json::heading(text));
  return *this;
}

Report& Report::paragraph(const std::string& text) {
  body_ += element("p", text);
  blocks_.emplace_back(json::paragraph(text));
  return *this;
}

Report& Report::facts(const std::vector<std::pair<std::string, std::string>>& facts) {
  blocks_.emplace_back(json::facts(facts));
  body_ += "<dl class=\"facts\">\n";
  for (const auto& [what, value] : facts)
    body_ += "<div>" + element("dt", what) + element("dd", value) + "</div>\n";
  body_ += "</dl>\n";
  return *this;
}

Report& Report::table(const eval::Table& table, const std::string& caption) {
  blocks_.emplace_back(json::table(table, caption));
  body_ += "<figure>\n";
  if (!caption.empty()) body_ += element("figcaption", caption);
  body_ += "<table><thead><tr>";
  for (const eval::Table::Column& column : table.columns()) {
    body_ += "<th>" + escape_html(column.name);
    if (!column.unit.empty())
      body_ += " <span class=\"unit\">[" + escape_html(column.unit) + "]</span>";
    body_ += "</th>";
  }
  body_ += "</tr></thead>\n<tbody>\n";
  for (const std::vector<std::string>& row : table.rows()) {
    body_ += "<tr>";
    for (const std::string& cell : row) body_ += "<td>" + escape_html(cell) + "</td>";
    body_ += "</tr>\n";
  }
  body_ += "</tbody></table>\n</figure>\n";
  return *this;
}

Report& Report::plot(const Plot& plot) {
  blocks_.emplace_back(plot);
  body_ += "<figure>\n";
  body_ += element("figcaption", plot.title) + legend(plot) + to_svg(plot);
  body_ += "</figure>\n";
  return *this;
}

Report& Report::image(const Image& image, const std::string& caption) {
  return encoded(encode_png(image), caption);
}

Report& Report::image(const PictureRows& picture, const std::string& caption) {
  constexpr std::size_t kMostPixels = 2048;  // more than a page is wide
  return encoded(encode_png(reduced(picture, kMostPixels)), caption);
}

Report& Report::encoded(const Result<std::string>& png, const std::string& caption) {
  if (!png) return paragraph(caption + ": " + png.error().to_string());
  blocks_.emplace_back(json::image(caption));
  body_ += "<figure>\n" + element("figcaption", caption) + "<img alt=\"" + escape_html(caption);
  body_ += "\" src=\"data:image/png;base64," + text::to_base64(*png) + "\">\n</figure>\n";
  return *this;
}

std::string Report::html() const {
  std::string out = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  out += "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n";
  out += element("title", title_) + "<style>" + kPlotStyle + kStyle +
         (doubt_.empty() ? "" : kDoubtStyle) + "</style>\n</head>\n<body>\n<main>\n";
  out += element("h1", title_);
  if (!subtitle_.empty()) out += "<p class=\"subtitle\">" + escape_html(subtitle_) + "</p>\n";
  if (!doubt_.empty())
    out += "<div class=\"doubt\" role=\"alert\"><strong>In doubt:</strong> " + escape_html(doubt_) +
           "</div>\n";
  return out + body_ + "</main>\n</body>\n</html>\n";
}

std::string Report::json() const {
  std::string out =
      "{\"title\": " + json::text(title_) + ",\n\"subtitle\": " + json::text(subtitle_) +
      (doubt_.empty() ? "" : ",\n\"doubt\": " + json::text(doubt_)) + ",\n\"blocks\": [";
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Plot* plot = std::get_if<Plot>(&blocks_[i]);
    out += (i == 0 ? "\n" : ",\n") + (plot ? json::plot(*plot) : std::get<std::string>(blocks_[i]));
  }
  return out + "\n]}\n";
}

}  // namespace wayfare::io
