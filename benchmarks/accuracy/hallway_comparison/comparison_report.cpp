#include "comparison_report.hpp"

#include <array>
#include <utility>

#include <wayfare/io/report.hpp>

#include "surface_picture.hpp"

namespace wayfare::examples {

eval::Table error_table(const std::vector<SeedRuns>& all) {
  eval::Table table({{"RMSE, mean \u00b1 standard deviation over seeds"},
                     {"x", "m"},
                     {"y", "m"},
                     {"heading", "deg"},
                     {"along 5 m", "m"},
                     {"across 5 m", "m"},
                     {"rotation in 5 m", "deg"}});
  for (std::size_t s = 0; s < kSensors.size(); ++s) {
    const auto cell = [&](double Errors::*field, int decimals) {
      std::vector<double> values;
      for (const SeedRuns& runs : all) values.push_back(runs.errors[s].*field);
      return eval::mean_std(values, decimals);
    };
    table.add_row({kNames[s], cell(&Errors::x_m, 2), cell(&Errors::y_m, 2),
                   cell(&Errors::heading_deg, 2), cell(&Errors::along_m, 3),
                   cell(&Errors::across_m, 3), cell(&Errors::rotation_deg, 2)});
  }
  return table;
}

eval::Table seed_table(const std::vector<SeedRuns>& all, std::uint64_t first) {
  eval::Table table({{"seed"},
                     {"LiDAR x", "m"},
                     {"y", "m"},
                     {"heading", "deg"},
                     {"along", "m"},
                     {"refused"},
                     {"radar x", "m"},
                     {"y", "m"},
                     {"heading", "deg"},
                     {"along", "m"},
                     {"refused"}});
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<std::string> row = {std::to_string(first + i)};
    for (const std::size_t s : {std::size_t{1}, std::size_t{2}}) {
      const Errors& e = all[i].errors[s];
      for (const double v : {e.x_m, e.y_m, e.heading_deg}) row.push_back(eval::fixed(v, 2));
      row.push_back(eval::fixed(e.along_m, 3));
      row.push_back(std::to_string(all[i].runs[s].refused) + " of " +
                    std::to_string(all[i].runs[s].refused + all[i].runs[s].matched));
    }
    table.add_row(std::move(row));
  }
  return table;
}

namespace {

io::Plot paths(const SeedRuns& runs) {
  io::Plot plot = io::top_view("Paths of the first seed");
  plot.series.push_back(io::path_series("truth", runs.truth));
  for (std::size_t s = 0; s < kSensors.size(); ++s)
    plot.series.push_back(io::path_series(kNames[s], runs.runs[s].trajectory));
  return plot;
}

std::string width_text(const ScoreSurface& surface) {
  const RidgeWidth width = ridge_width(surface);
  return "The positions within a tenth of the best score have a standard deviation of " +
         eval::fixed(width.along_m, 3) + " m along the corridor and " +
         eval::fixed(width.across_m, 3) + " m across it.";
}

Result<void> add_surfaces(const SeedRuns& runs, const OutputArguments& to, io::Report& report) {
  for (const std::size_t s : {std::size_t{1}, std::size_t{2}}) {
    if (!runs.runs[s].surface) continue;
    const io::Image image = surface_picture(*runs.runs[s].surface);
    const std::string file = s == 1 ? "score_lidar.png" : "score_radar.png";
    if (auto done = io::write_png(to.path(file), image, to.write()); !done) return done;
    report.image(image, std::string(kNames[s]) +
                            ": score of a scan in the map, up to 0.6 m ahead (up), behind and to "
                            "both sides. " +
                            width_text(*runs.runs[s].surface));
  }
  return {};
}

}  // namespace

std::string spread_text(const SeedRuns& runs) {
  std::string text;
  for (std::size_t s = 0; s < kSensors.size(); ++s)
    if (runs.runs[s].surface)
      text += std::string(kNames[s]) + ": " + width_text(*runs.runs[s].surface) + "\n";
  return text;
}

std::vector<std::string> comparison_files() {
  return {"report.html", "score_lidar.png", "score_radar.png"};
}

Result<void> write_comparison(const OutputArguments& to, const std::vector<SeedRuns>& all,
                              std::uint64_t first_seed) {
  io::Report report("Radar and LiDAR in long corridors",
                    "Scan-to-map matching only; wheel odometry gives the start of each search");
  report.table(error_table(all),
               "Root mean square errors: of the pose in the map's axes, and of the motion over "
               "straight segments of 5 m in the robot's axes");
  report.paragraph(
      "Zhang 2020, table 7, on a real corridor: odometry 4.75 m, 2.91 m, 28.8 deg; LiDAR 2.84 m, "
      "8.34 m, 6.69 deg; radar 0.46 m, 1.48 m, 6.51 deg.");
  report.plot(paths(all.front()));
  report.heading("Scores around one match");
  if (auto done = add_surfaces(all.front(), to, report); !done) return done;
  report.heading("Results by seed");
  report.table(seed_table(all, first_seed));
  return to.write_report(report);
}

}  // namespace wayfare::examples
