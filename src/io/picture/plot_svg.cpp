#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>

#include <wayfare/io/report.hpp>

#include "io/picture/plot_style.hpp"
#include "io/text/text.hpp"

namespace wayfare::io {
namespace {

constexpr double kWidth = 860.0, kLeft = 66.0, kRight = 18.0, kTop = 12.0, kBottom = 48.0;

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  [[nodiscard]] bool empty() const { return !(low <= high); }
  [[nodiscard]] double size() const { return high - low; }
  [[nodiscard]] double middle() const { return low + 0.5 * (high - low); }
  /// Margin around the data, also for a single value.
  void widen() {
    const double room = std::max(0.03 * size(), 1e-9 * std::max(std::abs(low), std::abs(high)));
    const double margin = room > 0.0 ? room : 1.0;
    low -= margin;
    high += margin;
  }
};

bool drawable(double v) { return std::abs(v) < 1e100; }  // false for NaN and infinities

/// 1, 2 or 5 times a power of ten, about `count` of them in `range`.
double tick_step(const Range& range, double count) {
  const double rough = range.size() / count;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= rough) return factor * power;
  return 10.0 * power;
}

std::string tick_text(double value, double step) {
  const double magnitude = std::max(std::abs(value), step);
  if (magnitude >= 1e7 || magnitude < 1e-5) {
    char buffer[40];
    const auto end =
        std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 4).ptr;
    return std::string(buffer, end);
  }
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  return text::fixed(std::abs(value) < 0.5 * step ? 0.0 : value, decimals);
}

/// The plot area and the mapping of data to it.
struct Frame {
  Range x, y;
  double height = 400.0;

  [[nodiscard]] double inner_width() const { return kWidth - kLeft - kRight; }
  [[nodiscard]] double inner_height() const { return height - kTop - kBottom; }
  [[nodiscard]] double px(double v) const { return kLeft + (v - x.low) / x.size() * inner_width(); }
  [[nodiscard]] double py(double v) const {
    return kTop + (y.high - v) / y.size() * inner_height();
  }
};

Frame frame_of(const Plot& plot) {
  Frame frame;
  if (plot.image) {
    for (const double x : {plot.image->left, plot.image->right}) frame.x.add(x);
    for (const double y : {plot.image->bottom, plot.image->top}) frame.y.add(y);
  }
  for (const Series& series : plot.series) {
    for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
      if (!drawable(series.x[i]) || !drawable(series.y[i])) continue;
      frame.x.add(series.x[i]);
      frame.y.add(series.y[i]);
    }
  }
  if (frame.x.empty()) return frame;
  frame.x.widen();
  frame.y.widen();
  if (!plot.equal_aspect) return frame;
  const double wanted = frame.inner_width() * frame.y.size() / frame.x.size();
  frame.height = std::clamp(wanted, 200.0, 620.0) + kTop + kBottom;
  const double scale =
      std::max(frame.x.size() / frame.inner_width(), frame.y.size() / frame.inner_height());
  for (auto [range, pixels] :
       {std::pair(&frame.x, frame.inner_width()), std::pair(&frame.y, frame.inner_height())}) {
    const double middle = range->middle();
    range->low = middle - 0.5 * scale * pixels;
    range->high = middle + 0.5 * scale * pixels;
  }
  return frame;
}

std::string fixed(double v) { return text::fixed(v, 1); }

std::string point(double x, double y) { return fixed(x) + ' ' + fixed(y); }

void append_text(std::string& out, double x, double y, const std::string& attributes,
                 const std::string& content) {
  out += "<text x=\"" + fixed(x) + "\" y=\"" + fixed(y) + "\" " + attributes + '>' +
         escape_html(content) + "</text>\n";
}

void append_line(std::string& out, const char* kind, double x1, double y1, double x2, double y2) {
  out += std::string("<path class=\"") + kind + "\" d=\"M" + point(x1, y1) + 'L' + point(x2, y2) +
         "\"/>\n";
}

void append_axes(std::string& out, const Frame& frame, const Plot& plot) {
  const double bottom = frame.height - kBottom;
  const double x_step = tick_step(frame.x, 8.0);
  const double y_step = tick_step(frame.y, std::max(3.0, frame.inner_height() / 45.0));
  // The tick count bounds the loop where the step is below the resolution of the numbers.
  for (int i = 0; i < 40; ++i) {
    const double x = (std::ceil(frame.x.low / x_step) + i) * x_step;
    if (x > frame.x.high) break;
    append_line(out, "grid", frame.px(x), kTop, frame.px(x), bottom);
    append_text(out, frame.px(x), bottom + 17.0, "text-anchor=\"middle\"", tick_text(x, x_step));
  }
  for (int i = 0; i < 40; ++i) {
    const double y = (std::ceil(frame.y.low / y_step) + i) * y_step;
    if (y > frame.y.high) break;
    append_line(out, "grid", kLeft, frame.py(y), kWidth - kRight, frame.py(y));
    append_text(out, kLeft - 8.0, frame.py(y) + 4.0, "text-anchor=\"end\"", tick_text(y, y_step));
  }
  append_line(out, "axis", kLeft, bottom, kWidth - kRight, bottom);
  append_text(out, kLeft + 0.5 * frame.inner_width(), frame.height - 8.0,
              "text-anchor=\"middle\" class=\"label\"", plot.x_label);
  const double middle = kTop + 0.5 * frame.inner_height();
  append_text(
      out, 14.0, middle,
      "text-anchor=\"middle\" class=\"label\" transform=\"rotate(-90 14 " + fixed(middle) + ")\"",
      plot.y_label);
}

struct Pixel {
  double x, y;
};

/// Thins a contiguous piece of a curve: where x is non-decreasing, each pixel column keeps its
/// first, lowest, highest and last point; elsewhere points less than half a pixel from the previous
/// one are dropped.
std::vector<Pixel> thinned(const std::vector<Pixel>& all) {
  const bool grows = std::is_sorted(all.begin(), all.end(),
                                    [](const Pixel& a, const Pixel& b) { return a.x < b.x; });
  if (all.size() < 800) return all;
  std::vector<Pixel> kept;
  for (std::size_t i = 0; i < all.size();) {
    std::size_t end = i + 1;
    if (!grows) {
      while (end + 1 < all.size() &&
             std::hypot(all[end].x - all[i].x, all[end].y - all[i].y) < 0.5) {
        ++end;
      }
      kept.push_back(all[i]);
      i = end;
      continue;
    }
    while (end < all.size() && std::floor(all[end].x) == std::floor(all[i].x)) ++end;
    const auto lower = [](const Pixel& a, const Pixel& b) { return a.y < b.y; };
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(i);
    const auto stop = all.begin() + static_cast<std::ptrdiff_t>(end);
    auto [low, high] = std::minmax_element(begin, stop, lower);
    if (high < low) std::swap(low, high);
    kept.push_back(*begin);
    if (low != begin) kept.push_back(*low);
    if (high != low) kept.push_back(*high);
    if (stop - 1 != high) kept.push_back(*(stop - 1));
    i = end;
  }
  return kept;
}

void append_pixels(std::string& out, const std::vector<Pixel>& piece, Mark mark) {
  const std::vector<Pixel> points = thinned(piece);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool dot = mark == Mark::points || mark == Mark::fine_points;
    out += i == 0 || dot ? 'M' : 'L';
    out += point(points[i].x, points[i].y);
    if (dot || points.size() == 1) out += "h0";  // a round cap makes it a dot
  }
}

void append_series(std::string& out, const Frame& frame, const Series& series, std::size_t index) {
  out += "<path class=\"" + curve_class(series.mark, index);
  if (series.mark == Mark::fine_points) out += "\" style=\"stroke-width:2.2";
  out += "\" d=\"";
  std::vector<Pixel> piece;
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    if (drawable(series.x[i]) && drawable(series.y[i])) {
      piece.push_back({frame.px(series.x[i]), frame.py(series.y[i])});
      continue;
    }
    append_pixels(out, piece, series.mark);
    piece.clear();
  }
  append_pixels(out, piece, series.mark);
  out += "\"/>\n";
}

void append_image(std::string& out, const Frame& frame, const PlotImage& below) {
  const Result<std::string> png = encode_png(below.image);
  if (!png) return;
  const double left = frame.px(below.left), top = frame.py(below.top);
  out += "<image x=\"" + fixed(left) + "\" y=\"" + fixed(top) + "\" width=\"" +
         fixed(frame.px(below.right) - left) + "\" height=\"" +
         fixed(frame.py(below.bottom) - top) +
         "\" preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" "
         "href=\"data:image/png;base64," +
         text::to_base64(*png) + "\"/>\n";
}

void append_plot(std::string& out, const Frame& frame, const Plot& plot) {
  if (frame.x.empty()) {
    append_text(out, 0.5 * kWidth, 0.5 * frame.height, "text-anchor=\"middle\"", "no data");
    return;
  }
  if (plot.image) append_image(out, frame, *plot.image);
  append_axes(out, frame, plot);
  for (std::size_t i = 0; i < plot.series.size(); ++i) append_series(out, frame, plot.series[i], i);
}

/// Below `top`, in lines as wide as the plot; returns its lower end.
double append_legend(std::string& out, const Plot& plot, double top) {
  constexpr double kLine = 20.0, kSample = 34.0, kLetter = 7.0, kGap = 18.0;
  double x = kLeft, y = top;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const double width = kSample + kLetter * static_cast<double>(plot.series[i].name.size());
    if (x > kLeft && x + width > kWidth - kRight) x = kLeft, y += kLine;
    out += "<g transform=\"translate(" + point(x, y) + ")\">" +
           legend_sample(plot.series[i].mark, i) + "</g>\n";
    append_text(out, x + kSample, y + 9.0, "", plot.series[i].name);
    x += width + kGap;
  }
  return y + kLine;
}

}  // namespace

std::string to_svg(const Plot& plot) {
  const Frame frame = frame_of(plot);
  std::string out = "<svg viewBox=\"0 0 " + point(kWidth, frame.height) +
                    "\" role=\"img\" aria-label=\"" + escape_html(plot.title) + "\">\n";
  append_plot(out, frame, plot);
  return out + "</svg>\n";
}

std::string to_svg_document(const Plot& plot) {
  const Frame frame = frame_of(plot);
  std::string head;
  append_text(head, kLeft, 22.0, "class=\"label\" font-weight=\"600\"", plot.title);
  const double top = append_legend(head, plot, 34.0);
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " +
                    point(kWidth, top + frame.height) + "\" font-family=\"sans-serif\">\n<style>" +
                    kPlotStyle +
                    "</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n" + head +
                    "<g transform=\"translate(0 " + fixed(top) + ")\">\n";
  append_plot(out, frame, plot);
  return out + "</g>\n</svg>\n";
}

}  // namespace wayfare::io
