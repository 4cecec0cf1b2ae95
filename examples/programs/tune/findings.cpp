#include "findings.hpp"

#include <cmath>

#include <wayfare/eval/nav_error.hpp>
#include <wayfare/tune/ins_fitness.hpp>

namespace wayfare::examples {
namespace {

std::string pair(double nominal, double tuned) {
  return eval::fixed(nominal, 3) + " → " + eval::fixed(tuned, 3);
}

eval::Table error_table(const DriveFinding& d) {
  eval::Table table({{"RMSE"}, {"position", "m"}, {"velocity", "m/s"}, {"attitude", "°"}});
  struct Row {
    const char* name;
    Eigen::Index axis, angle;
  };
  const SystemErrors &n = d.nominal, &t = d.tuned;
  for (const Row& r :
       {Row{"east / roll", 1, 0}, Row{"north / pitch", 0, 1}, Row{"altitude / yaw", 2, 2}}) {
    table.add_row({r.name, pair(n.position_ned_m[r.axis], t.position_ned_m[r.axis]),
                   pair(n.velocity_ned_mps[r.axis], t.velocity_ned_mps[r.axis]),
                   pair(n.attitude_deg[r.angle], t.attitude_deg[r.angle])});
  }
  table.add_row({"improvement factor (attitude: yaw)",
                 eval::fixed(n.position_m() / t.position_m(), 2),
                 eval::fixed(n.velocity_ned_mps.norm() / t.velocity_ned_mps.norm(), 2),
                 eval::fixed(n.attitude_deg[2] / t.attitude_deg[2], 2)});
  return table;
}

/// "nominal → tuned" in each cell.
eval::Table outage_table(const DriveFinding& d, std::string& remark) {
  const eval::Table before = eval::outage_table(*d.nominal_outages, &OutageError::rmse_m);
  const eval::Table after = eval::outage_table(*d.tuned_outages, &OutageError::rmse_m);
  eval::Table table(before.columns());
  std::size_t worse = 0, cells = 0;
  for (std::size_t r = 0; r < before.rows().size(); ++r) {
    std::vector<std::string> row = {before.rows()[r][0]};
    for (std::size_t c = 1; c < before.rows()[r].size(); ++c)
      row.push_back(before.rows()[r][c] + " → " + after.rows()[r][c]);
    table.add_row(std::move(row));
  }
  for (std::size_t i = 0; i < d.nominal_outages->cells.size(); ++i, ++cells)
    if (d.tuned_outages->cells[i].mean.rmse_m > d.nominal_outages->cells[i].mean.rmse_m) ++worse;
  remark = worse == 0
               ? "better in every cell"
               : "worse in " + std::to_string(worse) + " of " + std::to_string(cells) + " cells";
  return table;
}

eval::Table parameter_table(const TuneFindings& f) {
  eval::Table table({{"parameter"}, {"nominal"}, {"tuned"}, {"tuned over nominal"}});
  const auto names = ins_gene_bounds(f.nominal);
  const auto a = ins_genes(f.nominal), b = ins_genes(f.tuned);
  for (std::size_t i = 0; i < names.size(); ++i)
    table.add_row({names[i].name, eval::significant(a[i]), eval::significant(b[i]),
                   eval::significant(b[i] / a[i])});
  return table;
}

io::Plot convergence(const std::string& title) {
  return {title, "generation", "weighted sum of RMSE", {}};
}

io::Series series_of(const std::string& name, const GeneticState& state,
                     double GenerationSummary::*value, io::Mark mark) {
  io::Series s{name, {}, {}, mark};
  for (std::size_t g = 0; g < state.history.size(); ++g)
    s.add(static_cast<double>(g + 1), state.history[g].*value);
  return s;
}

}  // namespace

TitledTables tables_of(const TuneFindings& f) {
  TitledTables tables;
  for (const DriveFinding& d : f.drives)
    tables.emplace_back(
        (d.training ? "Training drive " : "Test drive ") + d.name + ", nominal → tuned",
        error_table(d));
  for (const DriveFinding& d : f.drives) {
    if (!d.nominal_outages || !d.tuned_outages) continue;
    std::string remark;
    eval::Table table = outage_table(d, remark);
    tables.emplace_back("Outages on " + d.name + ", horizontal RMSE, nominal → tuned: " + remark,
                        std::move(table));
  }
  tables.emplace_back("Parameters (SI)", parameter_table(f));
  return tables;
}

io::Report report_of(const TuneFindings& f, const std::string& title) {
  io::Report report(title,
                    "Nominal and tuned parameters; the whole navigation system on each drive");
  report.facts(f.facts);
  for (const auto& [name, table] : tables_of(f)) report.table(table, name);
  report.heading("Convergence");
  const std::size_t best = f.search.best();
  io::Plot one = convergence("Best run");
  one.series = {series_of("best", f.search.runs[best], &GenerationSummary::best, io::Mark::line),
                series_of("mean", f.search.runs[best], &GenerationSummary::mean, io::Mark::dashed)};
  // The means of the first generations are thousands of times the best.
  one.y_label = "log10 of the " + one.y_label;
  for (io::Series& series : one.series)
    for (double& y : series.y) y = std::log10(y);
  report.plot(one);
  io::Plot all = convergence("Best of each run");
  for (std::size_t r = 0; r < f.search.runs.size(); ++r)
    all.series.push_back(series_of("run " + std::to_string(r + 1), f.search.runs[r],
                                   &GenerationSummary::best, io::Mark::line));
  report.plot(all);
  return report;
}

}  // namespace wayfare::examples
