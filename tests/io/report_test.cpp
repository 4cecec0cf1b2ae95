#include <wayfare/io/report.hpp>

#include <cmath>
#include <limits>
#include <string>

#include "support.hpp"

namespace wayfare::io {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != text.npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(Report, EscapesAllText) {
  EXPECT_EQ(escape_html("<a href=\"x\">'&'</a> ° ✓"),
            "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt; ° ✓");
  EXPECT_EQ(escape_html(std::string("a\0b\x80\xffz\xe2\x82", 8)),
            "a\ufffdb\ufffd\ufffdz\ufffd\ufffd");
  const std::string evil = "<script>";
  eval::Table table({{evil, evil}});
  table.add_row({evil});
  const std::string html = Report(evil, evil)
                               .heading(evil)
                               .paragraph(evil)
                               .facts({{evil, evil}})
                               .table(table, evil)
                               .plot({evil, evil, evil, {{evil, {1}, {1}}, {evil, {2}, {2}}}})
                               .image({1, 1, 1, {0}}, evil)
                               .html();
  EXPECT_THAT(html, Not(HasSubstr(evil)));
  // Title 2, subtitle, heading, paragraph, fact 2, table 4, plot title and its text for readers,
  // two axes, two names, image caption and its text: 19.
  EXPECT_EQ(count(html, "&lt;script&gt;"), 19U);
}

TEST(Report, NeedsNoNetwork) {
  const std::string html = Report("t").image({1, 1, 3, {1, 2, 3}}, "picture").html();
  EXPECT_THAT(html, HasSubstr("src=\"data:image/png;base64,iVBORw0KGgo"));  // PNG's first bytes
  EXPECT_THAT(html, Not(HasSubstr("http")));
  EXPECT_THAT(html, Not(HasSubstr("url(")));
}

TEST(Report, AnInvalidPictureIsReplacedByALine) {
  EXPECT_THAT(Report("t").image({}, "map").html(), HasSubstr("map: a picture of 0 x 0 pixels"));
}

TEST(Report, ADoubtStandsAboveTheBlocks) {
  Report report("t");
  report.heading("Map");
  const std::string html = report.html();
  EXPECT_THAT(html, Not(HasSubstr("doubt")));
  EXPECT_THAT(report.json(), Not(HasSubstr("doubt")));
  EXPECT_EQ(report.doubt("3 < 4").doubt("").html(), html);
  const std::string doubted = report.doubt("3 < 4").html();
  EXPECT_LT(doubted.find("3 &lt; 4"), doubted.find("<h2>Map"));
  EXPECT_GT(doubted.find("3 &lt; 4"), doubted.find("<h1>t"));
  EXPECT_THAT(report.json(), HasSubstr("\"doubt\": \"3 < 4\",\n\"blocks\""));
}

TEST(Plot, PlacesPointsExactly) {
  // One series from (0, 0) to (10, 5): widened by 3 %, so 0 lies 0.3/10.6 of the width in.
  const std::string svg = to_svg({"t", "x", "y", {{"s", {0, 10}, {0, 5}, Mark::line}}});
  // Width 860 - 66 - 18 = 776, height 400 - 12 - 48 = 340.
  // x: 66 + 776*0.3/10.6 = 88.0 and 820.0; y: 12 + 340*5.15/5.3 = 342.4 and 21.6.
  EXPECT_THAT(svg, HasSubstr("M88.0 342.4L820.0 21.6"));
}

TEST(Plot, EqualAspect) {
  // A square of data: a metre has the same number of pixels on both axes.
  const std::string svg =
      to_svg({"t", "x", "y", {{"s", {0, 1, 1, 0}, {0, 0, 1, 1}, Mark::line}}, true});
  double ax = 0, ay = 0, bx = 0, by = 0, cx = 0, cy = 0;
  const std::size_t at = svg.find("line\" d=\"M");
  ASSERT_NE(at, svg.npos);
  ASSERT_EQ(std::sscanf(svg.c_str() + at, "line\" d=\"M%lf %lfL%lf %lfL%lf %lf", &ax, &ay, &bx, &by,
                        &cx, &cy),
            6);
  EXPECT_NEAR(bx - ax, by - cy, 0.11);
  EXPECT_GT(bx - ax, 100.0);
}

TEST(Plot, HandlesAnyNumbers) {
  const double inf = std::numeric_limits<double>::infinity();
  const double big = std::numeric_limits<double>::max();
  const Plot plots[] = {
      {"", "", "", {}},
      {"", "", "", {{"", {}, {}}}},
      {"", "", "", {{"", {1, 2, 3}, {1}}}},
      {"", "", "", {{"", {NAN, 1, inf, 2}, {1, NAN, 1, -inf}}}},
      {"", "", "", {{"", {5, 5}, {1e17, 1e17}}}, true},
      {"", "", "", {{"", {0, 1e-300}, {0, 1e-300}}}},
      {"", "", "", {{"", {1e9, 1e9 + 1e-7}, {-big, big}}}},
      {"", "", "", {{"", {-1e99, 1e99}, {-1e99, 1e99}}}, true},
  };
  for (const Plot& plot : plots) {
    const std::string svg = to_svg(plot);
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    EXPECT_THAT(svg, Not(HasSubstr("inf")));
    EXPECT_LT(svg.size(), 100'000U);
  }
}

TEST(Plot, ThinningKeepsTheSpike) {
  Series series{"s", {}, {}};
  for (int i = 0; i < 200000; ++i) {
    series.x.push_back(i);
    series.y.push_back(i == 123456 ? 100.0 : std::sin(0.7 * i));
  }
  const std::string svg = to_svg({"t", "x", "y", {series}});
  EXPECT_LT(svg.size(), 60'000U);
  // The spike reaches the top: y from -1 to 100 widened by 3.03 lies at 12 + 340*3.03/107.06.
  EXPECT_THAT(svg, HasSubstr(" 21.6"));
}

TEST(Plot, AGapBreaksTheLine) {
  const std::string svg = to_svg({"t", "x", "y", {{"s", {0, 1, 2, 3}, {0, NAN, 1, 0}}}});
  const std::string path = svg.substr(svg.find("line\" d=\""));
  EXPECT_EQ(count(path, "M"), 2U);
}

TEST(Plot, APictureLiesBelowTheCurvesInTheUnitsOfTheAxes) {
  GridImage grid;
  grid.width = 20, grid.height = 10, grid.resolution_m = 0.5;
  grid.origin = SE2d(2.0, 3.0, Angle());
  grid.occupancy.assign(200, 0.0F);
  Plot plot = top_view("map");
  plot.image = plot_image(grid);
  EXPECT_EQ(plot.image->right, 12.0);
  EXPECT_EQ(plot.image->top, 8.0);
  plot.series = {{"corners", {2.0, 12.0}, {8.0, 3.0}, Mark::points}};
  const std::string svg = to_svg(plot);
  const auto number_after = [&](const std::string& what) {
    return std::stod(svg.substr(svg.find(what) + what.size()));
  };
  const std::size_t image = svg.find("<image ");
  ASSERT_NE(image, std::string::npos);
  EXPECT_LT(image, svg.find("class=\"s0"));
  EXPECT_NE(svg.find("data:image/png;base64,"), std::string::npos);
  const double x = number_after("<image x=\""), y = number_after("\" y=\"");
  EXPECT_NE(svg.find("s0 dots"), std::string::npos);
  EXPECT_NEAR(number_after("s0 dots\" d=\"M"), x, 0.11);
  EXPECT_GT(number_after("width=\""), 1.9 * number_after("height=\""));
  EXPECT_GT(y, 0.0);
  plot.image.reset();
  EXPECT_EQ(to_svg(plot).find("<image"), std::string::npos);
}

TEST(Plot, FinePointsAreDotsWithAThinPen) {
  const std::string svg = to_svg({"t", "x", "y", {{"s", {0, 10}, {0, 5}, Mark::fine_points}}});
  EXPECT_NE(svg.find("s0 dots\" style=\"stroke-width:2.2\""), std::string::npos);
}

}  // namespace
}  // namespace wayfare::io
