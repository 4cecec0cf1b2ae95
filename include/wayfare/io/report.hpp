#pragma once

// A run report as one self-contained HTML file with facts, tables, plots and images, viewable
// without a network. Colours follow the reader's light or dark setting. Its numbers as JSON.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <wayfare/core/result.hpp>
#include <wayfare/eval/table.hpp>
#include <wayfare/io/map_image.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/sensors/trajectory.hpp>

namespace wayfare::io {

/// How a series is drawn.
enum class Mark {
  line,         ///< through the points
  dashed,       ///< through the points
  points,       ///< alone
  fine_points,  ///< alone, small: scans
};

/// One curve: y over x, of the same length. A point that is not finite breaks the line.
struct Series {
  std::string name;        ///< in the legend
  std::vector<double> x;   ///< abscissae
  std::vector<double> y;   ///< ordinates
  Mark mark = Mark::line;  ///< how it is drawn

  /// Appends a point.
  void add(double x_value, double y_value) {
    x.push_back(x_value);
    y.push_back(y_value);
  }
};

/// A picture below the curves, with its edges in the units of the axes.
struct PlotImage {
  Image image;          ///< drawn below the curves
  double left = 0.0;    ///< on the x axis
  double right = 0.0;   ///< on the x axis
  double bottom = 0.0;  ///< on the y axis
  double top = 0.0;     ///< on the y axis
};
/// The picture of a map, in metres. Its origin must not be rotated.
[[nodiscard]] PlotImage plot_image(const GridImage& grid);

/// Curves over common axes.
struct Plot {
  std::string title;           ///< above the plot
  std::string x_label;         ///< with its unit: "time [s]"
  std::string y_label;         ///< with its unit
  std::vector<Series> series;  ///< coloured in order, eight distinct colours
  /// Equal scale of both axes, e.g. for trajectories.
  bool equal_aspect = false;
  std::optional<PlotImage> image = {};  ///< left out if it cannot be encoded
};

/// An empty plot over time.
[[nodiscard]] inline Plot time_plot(std::string title, std::string y_label) {
  return {std::move(title), "time [s]", std::move(y_label), {}};
}
/// An empty plot of the plane.
[[nodiscard]] inline Plot top_view(std::string title) {
  return {std::move(title), "x [m]", "y [m]", {}, true};
}
/// The positions of a trajectory, moved by `T`.
[[nodiscard]] Series path_series(std::string name, const Trajectory& trajectory, const SE2d& T = {},
                                 Mark mark = Mark::line);
/// A curve of angles in degrees, with a gap at each jump from 180 to -180.
[[nodiscard]] Series broken_at_wraps(const Series& series);
/// The curves ± `upper` as one series with a gap, so that both share a colour and a line of the
/// legend.
[[nodiscard]] Series bounds_series(const Series& upper);

/// The plot alone, an SVG element with colours from the report's style. Curves are thinned to the
/// resolution of the plot; extremes are kept, so that a single spike remains visible.
[[nodiscard]] std::string to_svg(const Plot& plot);
/// The same as a file of its own, with title and legend, on white.
[[nodiscard]] std::string to_svg_document(const Plot& plot);

/// Blocks appear in the order they are added. All text is escaped.
class Report {
 public:
  /// A report without blocks.
  explicit Report(std::string title, std::string subtitle = {});

  /// Why the results are in doubt, in a box below the title; of the last call. Empty: no box.
  Report& doubt(const std::string& why) {
    doubt_ = why;
    return *this;
  }
  /// A heading in the report.
  Report& heading(const std::string& text);
  /// Plain text.
  Report& paragraph(const std::string& text);
  /// Key figures: name, and value with its unit.
  Report& facts(const std::vector<std::pair<std::string, std::string>>& facts);
  /// The first column contains the row names.
  Report& table(const eval::Table& table, const std::string& caption = {});
  /// The plot with its title and legend.
  Report& plot(const Plot& plot);
  /// If the image cannot be encoded, a line with the reason is written instead.
  Report& image(const Image& image, const std::string& caption);
  /// The same of a picture made row by row; a larger one is reduced to 2048 pixels.
  Report& image(const PictureRows& picture, const std::string& caption);

  /// The whole file.
  [[nodiscard]] std::string html() const;
  /// The same blocks in their order as one JSON object: {"title", "subtitle", "blocks": […]},
  /// with "doubt" before the blocks where there is one. A block has one member, which says its
  /// kind:
  /// - "heading", "paragraph" and "image" (its caption): text;
  /// - "facts": [{"name", "text", "value", "unit"}], value and unit where the text is a number with
  ///   or without a unit;
  /// - "table": {"caption", "columns": [{"name", "unit"}], "rows": [[…]]}, a cell a number, null
  ///   for one that is not finite, {"mean", "std"} for mean ± std, else text; the first column is
  ///   text;
  /// - "plot": {"title", "x_label", "y_label", "series": [{"name", "x": […], "y": […]}]}, with all
  ///   points; null where a curve is broken.
  [[nodiscard]] std::string json() const;
  /// Errors: the file exists (see WriteOptions), or cannot be written.
  [[nodiscard]] Result<void> write(const std::string& path,
                                   const WriteOptions& options = {}) const {
    return write_file(path, html(), options);
  }

 private:
  Report& encoded(const Result<std::string>& png, const std::string& caption);

  std::string title_;
  std::string subtitle_;
  std::string doubt_;
  std::string body_;
  std::vector<std::variant<std::string, Plot>> blocks_;  ///< a plot, or a block as JSON
};

/// `text` with &, <, >, " and ' as entities, and control characters and invalid UTF-8 replaced.
[[nodiscard]] std::string escape_html(std::string_view text);

}  // namespace wayfare::io
