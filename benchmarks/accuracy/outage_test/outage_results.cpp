#include "outage_results.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <wayfare/core/statistics.hpp>

namespace wayfare::examples {
namespace {

eval::Table outside_table(const std::vector<OutageVariant>& variants) {
  eval::Table table({{"outside outages"}, {"horizontal RMSE", "m"}, {"largest", "m"}});
  const auto row = [&](const std::string& name, const std::vector<double>& errors) {
    const Summary s = summarise(errors);
    table.add_row({name, eval::fixed(s.rmse, 2), eval::fixed(s.max, 2)});
  };
  for (const OutageVariant& v : variants) row(v.name, v.outside.filter);
  row("plain GNSS", variants.front().outside.plain);
  return table;
}

struct Figure {
  const char* name;
  double OutageError::*value;
};
constexpr std::array kFigures = {Figure{"error at the end", &OutageError::end_m},
                                 Figure{"horizontal RMSE", &OutageError::rmse_m},
                                 Figure{"largest error", &OutageError::max_m}};

io::Plot cell_plot(const OutageVariant& v, const Figure& figure) {
  io::Plot plot{
      std::string("Mean ") + figure.name + ", " + v.name, "length of the outage [s]", "[m]", {}};
  for (const OutageCell& c : v.report.cells) {
    const std::string name = std::to_string(c.satellites_left) + " satellites left";
    auto series = std::find_if(plot.series.begin(), plot.series.end(),
                               [&](const io::Series& s) { return s.name == name; });
    if (series == plot.series.end()) series = plot.series.insert(series, {name, {}, {}});
    series->add(to_seconds(c.duration), c.mean.*figure.value);
  }
  return plot;
}

/// Every outage without satellites: error over time or distance.
io::Plot drift_plot(const OutageVariant& v, bool by_distance) {
  io::Plot plot{std::string("Each outage without satellites, ") + v.name,
                by_distance ? "distance travelled [m]" : "time in the outage [s]",
                "horizontal error [m]",
                {}};
  for (const OutageCourse& course : v.report.courses) {
    if (course.window.satellites_left != 0) continue;
    io::Series s{
        "from " + eval::fixed(std::fmod(course.window.begin.seconds(), 1e5), 0) + " s", {}, {}};
    for (std::size_t i = 0; i < course.drift.size(); i += 10)
      s.add(by_distance ? course.drift[i].distance_m : course.drift[i].time_s,
            course.drift[i].error_m);
    plot.series.push_back(std::move(s));
  }
  return plot;
}

/// The largest error of any of the outages a cell is the mean of.
eval::Table worst_table(const OutageVariant& v) {
  OutageReport worst = v.report;
  std::size_t duration = 0;
  for (OutageCell& cell : worst.cells) {
    if (&cell != worst.cells.data() && cell.duration != (&cell - 1)->duration) ++duration;
    cell.mean.max_m = 0.0;
    for (const OutageCourse& course : v.report.courses)
      if (course.window.satellites_left == cell.satellites_left)
        cell.mean.max_m = std::max(cell.mean.max_m, course.by_duration[duration].max_m);
  }
  return eval::outage_table(worst, &OutageError::max_m);
}

}  // namespace

TitledTables outage_tables(const std::vector<OutageVariant>& variants, std::size_t places) {
  TitledTables tables;
  for (const Figure& figure : kFigures)
    for (const OutageVariant& v : variants)
      tables.emplace_back(std::string("Mean of the ") + figure.name + " over " +
                              std::to_string(places) + " start times, " + v.name,
                          eval::outage_table(v.report, figure.value));
  for (const OutageVariant& v : variants)
    tables.emplace_back("Largest error at any start time, " + v.name, worst_table(v));
  tables.emplace_back("Outside of outages", outside_table(variants));
  return tables;
}

io::Report outage_report(const std::string& title, const std::string& description,
                         const std::vector<OutageVariant>& variants, const TitledTables& tables) {
  io::Report report(title, description);
  for (const auto& [name, table] : tables) report.table(table, name);
  report.heading("Plots of the tables");
  for (const Figure& figure : kFigures)
    for (const OutageVariant& v : variants) report.plot(cell_plot(v, figure));
  report.heading("Single outages");
  for (const OutageVariant& v : variants)
    report.plot(drift_plot(v, false)).plot(drift_plot(v, true));
  return report;
}

}  // namespace wayfare::examples
