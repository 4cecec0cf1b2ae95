// The report's JSON, read by an independent parser.

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <wayfare/io/report.hpp>

namespace wayfare::io {
namespace {

using nlohmann::json;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

json block_of(const Report& report, const char* kind) {
  const json parsed = json::parse(report.json());
  EXPECT_EQ(parsed["blocks"].size(), 1U);
  return parsed["blocks"][0][kind];
}

TEST(ReportJson, KeepsTheOrderOfTheBlocks) {
  eval::Table table({{"method"}, {"error", "m"}});
  const json parsed = json::parse(Report("Title", "subtitle")
                                      .heading("h")
                                      .paragraph("p")
                                      .facts({{"scans", "3"}})
                                      .table(table)
                                      .plot({"t", "x", "y", {}})
                                      .image({1, 1, 1, {0}}, "map")
                                      .json());
  EXPECT_EQ(parsed["title"], "Title");
  EXPECT_EQ(parsed["subtitle"], "subtitle");
  std::string kinds;
  for (const json& block : parsed["blocks"]) {
    EXPECT_EQ(block.size(), 1U);
    kinds += block.begin().key() + " ";
  }
  EXPECT_EQ(kinds, "heading paragraph facts table plot image ");
  EXPECT_EQ(parsed["blocks"][5]["image"], "map");
}

TEST(ReportJson, AnEmptyReportIsAnObjectWithoutBlocks) {
  EXPECT_EQ(json::parse(Report("").json()),
            json::parse(R"({"title":"","subtitle":"","blocks":[]})"));
}

TEST(ReportJson, ReadsNumbersOutOfCellsAndKeepsUnits) {
  eval::Table table({{"method"}, {"error", "m"}, {"spread"}});
  table.add_row({"SLAM", "0.250", eval::mean_std(1.5, 0.25, 3)});
  table.add_row({"12", eval::fixed(kNan, 3), "12 of 13"});
  table.add_row({"none", "inf", "nan"});
  table.add_row({"signs", "+0.5", "-2e-3"});
  const json found = block_of(Report("t").table(table, "Errors"), "table");
  EXPECT_EQ(found, json::parse(R"({"caption": "Errors",
      "columns": [{"name": "method", "unit": ""}, {"name": "error", "unit": "m"},
                  {"name": "spread", "unit": ""}],
      "rows": [["SLAM", 0.25, {"mean": 1.5, "std": 0.25}],
               ["12", null, "12 of 13"],
               ["none", null, null],
               ["signs", 0.5, -0.002]]})"));
}

TEST(ReportJson, SplitsFactsIntoValueAndUnit) {
  const json found = block_of(Report("t").facts({{"scans", "4791"},
                                                 {"memory", "12.5 MiB"},
                                                 {"took", "1.2 s, 30 times real time"},
                                                 {"share", eval::fixed(kNan, 1) + " %"},
                                                 {"file", "map.png"},
                                                 {"empty", ""}}),
                              "facts");
  EXPECT_EQ(found, json::parse(R"([
      {"name": "scans", "text": "4791", "value": 4791, "unit": ""},
      {"name": "memory", "text": "12.5 MiB", "value": 12.5, "unit": "MiB"},
      {"name": "took", "text": "1.2 s, 30 times real time"},
      {"name": "share", "text": "– %", "value": null, "unit": "%"},
      {"name": "file", "text": "map.png"},
      {"name": "empty", "text": ""}])"));
}

TEST(ReportJson, HasAllPointsOfCurvesExactlyAndNullWhereTheyBreak) {
  Series series{"path", {0.1, 1.0 / 3.0, kNan, 4.0}, {-1e-300, kInf, kNan, 5e300}};
  series.x.push_back(6.0);  // without its y: not a point
  const json found = block_of(Report("t").plot({"Paths", "x [m]", "y [m]", {series}}), "plot");
  EXPECT_EQ(found["title"], "Paths");
  EXPECT_EQ(found["x_label"], "x [m]");
  EXPECT_EQ(found["y_label"], "y [m]");
  ASSERT_EQ(found["series"].size(), 1U);
  const json& path = found["series"][0];
  EXPECT_EQ(path["name"], "path");
  EXPECT_EQ(path["x"], json({0.1, 1.0 / 3.0, nullptr, 4.0}));
  EXPECT_EQ(path["y"], json({-1e-300, nullptr, nullptr, 5e300}));
}

TEST(ReportJson, EscapesAllText) {
  const std::string evil = "\"\\\n\t\x01\x7f</script> ° ✓";
  const std::string invalid = std::string("a\0b", 3) + "\x80\xc0\xaf\xed\xa0\x80\xf5z";
  const std::string repaired =
      std::string("a\0b", 3) + "\ufffd\ufffd\ufffd\ufffd\ufffd\ufffd\ufffdz";
  eval::Table table({{evil, evil}});
  table.add_row({evil});
  const json parsed = json::parse(Report(evil, invalid)
                                      .heading(evil)
                                      .facts({{evil, evil}})
                                      .table(table, evil)
                                      .plot({evil, evil, evil, {{evil, {1}, {1}}}})
                                      .json());
  EXPECT_EQ(parsed["title"], evil);
  EXPECT_EQ(parsed["subtitle"], repaired);
  EXPECT_EQ(parsed["blocks"][0]["heading"], evil);
  EXPECT_EQ(parsed["blocks"][1]["facts"][0]["name"], evil);
  EXPECT_EQ(parsed["blocks"][2]["table"]["rows"][0][0], evil);
  EXPECT_EQ(parsed["blocks"][3]["plot"]["series"][0]["name"], evil);
}

}  // namespace
}  // namespace wayfare::io
