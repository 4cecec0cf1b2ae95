#include <array>

#include <wayfare/eval/trajectory_error.hpp>
#include <wayfare/sensors/trajectory.hpp>

#include "job.hpp"
#include "outputs.hpp"

namespace wayfare::examples {
namespace {

/// Mean yaw rate of the motion minus that of the reference, rad/s.
double reference_bias(std::span<const MotionSample> motion, const Trajectory& reference) {
  double measured = 0.0, rotated = 0.0, seconds = 0.0;
  for (std::size_t i = 1; i < motion.size(); ++i) {
    const auto a = pose_at(reference, motion[i - 1].time);
    const auto b = pose_at(reference, motion[i].time);
    if (!a || !b) continue;
    const double dt = to_seconds(motion[i].time - motion[i - 1].time);
    measured += motion[i].turn_rate_rad_s * dt;
    rotated += (a->inverse() * *b).heading().radians();
    seconds += dt;
  }
  return (measured - rotated) / seconds;
}

std::string rate(double rad_s) {
  return eval::fixed(Angle::radians(rad_s).degrees(), 4) + " deg/s";
}

void add_bias_facts(const Job& job, const Runs& runs, const CorridorArguments& o, Facts& facts) {
  const CorridorEpoch& last = runs.aided.epochs.back();
  facts.emplace_back("gyro bias", rate(last.gyro_bias.value) + " +- " + rate(last.gyro_bias.sigma));
  if (job.drive)
    facts.emplace_back("true bias", rate(true_bias_at(*job.drive, last.time) +
                                         Angle::degrees(o.added_bias_deg_s).radians()));
  const auto motion = motion_of(job.recording, Angle::degrees(o.added_bias_deg_s).radians());
  if (!job.drive && !job.reference.empty())
    facts.emplace_back("by reference", rate(reference_bias(motion, job.reference)));
  if (!runs.without_added) return;
  const double plain = runs.without_added->epochs.back().gyro_bias.value;
  const double found = Angle::radians(last.gyro_bias.value - plain).degrees();
  facts.emplace_back("without the added", rate(plain));
  facts.emplace_back("added bias found", eval::fixed(100.0 * found / o.added_bias_deg_s, 2) +
                                             " % of " + eval::fixed(o.added_bias_deg_s, 3) +
                                             " deg/s");
}

void add_report_facts(const CorridorReport& r, Facts& facts) {
  const auto share = [&](std::size_t n) {
    return std::to_string(n) + " (" +
           eval::fixed(100.0 * static_cast<double>(n) / static_cast<double>(r.scans), 1) + " %)";
  };
  facts.emplace_back("scans", std::to_string(r.scans));
  facts.emplace_back("with walls", share(r.scans_with_walls));
  facts.emplace_back("walls used", share(r.scans_used));
  facts.emplace_back("by tracking", share(r.tracked));
  facts.emplace_back("end walls", share(r.end_walls_used));
  facts.emplace_back("corridors", std::to_string(r.corridors));
  facts.emplace_back("longest outage", eval::fixed(to_seconds(r.longest_outage), 1) + " s");
  facts.emplace_back("refused", std::to_string(r.refused_walls) + " scans, " +
                                    std::to_string(r.refused_sides) + " sides, " +
                                    std::to_string(r.refused_end_walls) + " end walls, " +
                                    std::to_string(r.not_parallel) + " not parallel, " +
                                    std::to_string(r.slipping_samples) + " slipping, " +
                                    std::to_string(r.saturated_samples) + " saturated");
}

}  // namespace

Facts facts_of(const Job& job, const Runs& runs, const CorridorArguments& o) {
  Facts facts;
  add_bias_facts(job, runs, o, facts);
  add_report_facts(runs.aided.report, facts);
  return facts;
}

eval::Table section_table(const Job& job, const Runs& runs) {
  std::vector<eval::Table::Column> columns{{""}};
  for (int s = 0; s < 5; ++s)
    columns.push_back({std::string(sim::name_of(static_cast<sim::CorridorSection>(s))), "m"});
  columns.push_back({"Total", "m"});
  eval::Table table(columns);
  const std::array<std::pair<const char*, const CorridorRun*>, 2> rows = {
      {{"with walls", &runs.aided}, {"without", &runs.unaided}}};
  for (const auto& [name, run] : rows) {
    std::vector<std::string> row{name};
    for (const double e : errors_of(*run, *job.drive, job.rest_s).position_rmse_m)
      row.push_back(eval::fixed(e, 3));
    table.add_row(std::move(row));
  }
  return table;
}

eval::Table reference_table(const Job& job, const Runs& runs) {
  eval::Table table({{""}, {"RMSE", "m"}, {"heading", "deg"}, {"largest", "m"}});
  const std::array<std::pair<const char*, const CorridorRun*>, 2> rows = {
      {{"with walls", &runs.aided}, {"without", &runs.unaided}}};
  for (const auto& [name, run] : rows) {
    const auto e = eval::absolute_error(trajectory_of(*run), job.reference);
    table.add_row({name, eval::fixed(e.translation_m.rmse, 3), eval::fixed(e.rmse_heading_deg, 2),
                   eval::fixed(e.translation_m.max, 3)});
  }
  return table;
}

}  // namespace wayfare::examples
