#include "outputs.hpp"

#include <wayfare/eval/table.hpp>
#include <wayfare/io/report.hpp>
#include <wayfare/io/tum.hpp>

namespace wayfare::examples {
namespace {

std::vector<eval::Evaluated> errors_of(const MethodOutputs& o) {
  std::vector<NamedTrajectory> all;
  for (const MethodRun& run : o.runs) all.push_back({run.title, run.trajectory});
  return compare(o.truth, all);
}

eval::Table paths_table(const MethodOutputs& o) {
  eval::Table table({{""}, {"poses"}, {"from", "s"}, {"to", "s"}, {"path", "m"}, {"end", "m"}});
  for (const MethodRun& run : o.runs) {
    const Trajectory& t = run.trajectory;
    const SE2d moved = t.front().T_map_base.raw().inverse() * t.back().T_map_base.raw();
    table.add_row({run.title, std::to_string(t.size()), eval::fixed(t.front().time.seconds(), 3),
                   eval::fixed(t.back().time.seconds(), 3), eval::fixed(eval::path_length_m(t), 2),
                   eval::fixed(moved.translation().norm(), 3)});
  }
  return table;
}

eval::Table left_out_table(const MethodOutputs& o) {
  eval::Table table({{"method"}, {"reason"}});
  for (const auto& [name, reason] : o.left_out) table.add_row({name, reason});
  return table;
}

/// Each path moved by its alignment, and the true path.
io::Plot paths_plot(const std::string& title, const MethodOutputs& o,
                    const std::vector<SE2d>& alignments) {
  io::Plot plot = io::top_view(title);
  for (std::size_t i = 0; i < o.runs.size(); ++i)
    plot.series.push_back(io::path_series(o.runs[i].title, o.runs[i].trajectory, alignments[i]));
  if (o.truth.known())
    plot.series.push_back(io::path_series("truth", o.truth.poses, {}, io::Mark::dashed));
  return plot;
}

/// Started at the same pose; with truth also after rigid alignment, in the truth's frame.
std::vector<io::Plot> paths_plots(const MethodOutputs& o,
                                  const std::vector<eval::Evaluated>& errors) {
  std::vector<SE2d> start, rigid;
  for (const MethodRun& run : o.runs)
    start.push_back(run.trajectory.front().T_map_base.raw().inverse());
  if (errors.empty()) return {paths_plot("Paths, started at the same pose", o, start)};
  std::vector<io::Plot> plots;
  for (const eval::Evaluated& e : errors) rigid.push_back(e.errors.rigid.alignment);
  for (std::size_t i = 0; i < errors.size(); ++i) start[i] = errors[i].errors.start.alignment;
  plots.push_back(paths_plot("Paths after rigid alignment", o, rigid));
  if (o.truth.has_heading) plots.push_back(paths_plot("Paths, started at the same pose", o, start));
  return plots;
}

}  // namespace

TitledTables tables_of(const MethodOutputs& o) {
  TitledTables tables{{"Paths", paths_table(o)}};
  const TitledTables errors = error_tables(o.truth, errors_of(o));
  tables.insert(tables.end(), errors.begin(), errors.end());
  if (!o.left_out.empty()) tables.emplace_back("Left out", left_out_table(o));
  return tables;
}

std::vector<std::string> files_of(const std::vector<std::string>& methods) {
  std::vector<std::string> files{"paths.svg", "report.html"};
  for (const std::string& name : methods) files.push_back(name + ".tum");
  return files;
}

Result<void> write_methods(const OutputArguments& to, const MethodOutputs& o) {
  for (const MethodRun& run : o.runs)
    if (auto done = io::write_tum(to.path(run.name + ".tum"), run.trajectory, to.write()); !done)
      return done;
  const std::vector<eval::Evaluated> errors = errors_of(o);
  const std::vector<io::Plot> paths = paths_plots(o, errors);
  io::Report report(o.title);
  report.doubt(o.doubt).facts(o.facts);
  for (const auto& [title, table] : tables_of(o)) report.heading(title).table(table);
  report.heading("Paths");
  for (const io::Plot& plot : paths) report.plot(plot);
  if (!errors.empty()) report.heading("Errors over time");
  for (const io::Plot& plot : distance_plots(o.truth, errors)) report.plot(plot);
  return first_error(
      {io::write_file(to.path("paths.svg"), io::to_svg_document(paths.front()), to.write()),
       to.write_report(report)});
}

}  // namespace wayfare::examples
