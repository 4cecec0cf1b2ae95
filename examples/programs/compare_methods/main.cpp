// Several methods on one log: their paths and errors in one table and one picture.

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "methods.hpp"
#include "outputs.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

struct Options : SlamArguments {
  std::vector<std::string> methods;
  UnitOptions unit;
};

std::vector<std::string> names_of_methods() {
  std::vector<std::string> names;
  for (const Method& method : methods()) names.push_back(method.name);
  return names;
}

/// Those of --methods, in the order of the list; all of them by default.
std::vector<const Method*> chosen(const Options& o) {
  std::vector<const Method*> result;
  for (const Method& method : methods())
    if (o.methods.empty() || std::ranges::count(o.methods, method.name) > 0)
      result.push_back(&method);
  return result;
}

Result<MethodData> read_data(const Options& o, Doubt& doubt) {
  auto recording = read_robot_log(o.log, o.topics, true, &doubt);
  if (!recording) return recording.error();
  drop_still_odometry(*recording);
  auto unit = o.unit.read(o.log, o.topics);
  if (!unit) return unit.error();
  return MethodData{*std::move(recording), *std::move(unit), o.unit, o.threads, o.seed};
}

/// A method that fails is left out, with the reason.
void run_all(const Options& o, const MethodData& data, MethodOutputs& outputs) {
  const std::vector<const Method*> all = chosen(o);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Method& method = *all[i];
    std::string reason = method.lacks(data);
    if (reason.empty()) {
      const std::string label =
          std::to_string(i + 1) + " of " + std::to_string(all.size()) + ", " + method.title;
      auto run = run_timed(label, o.quiet, [&](ProgressLine& progress) {
        return method.run(data, std::ref(progress));
      });
      if (run && !run->slam.empty()) {
        outputs.runs.push_back({method.name, method.title, std::move(run->slam)});
        continue;
      }
      reason = run ? "gives no pose" : run.error().to_string();
    }
    outputs.left_out.emplace_back(method.name, std::move(reason));
  }
}

Facts facts_of(const MethodData& data, const Truth& truth) {
  const Recording& r = data.recording;
  Facts facts = {{"scans", std::to_string(r.scans.size())},
                 {"radar frames", std::to_string(r.radar.size())},
                 {"odometry", std::to_string(r.odometry.size()) + " samples"}};
  if (data.unit)
    facts.emplace_back("inertial unit",
                       std::to_string(data.unit->file.samples.size()) + " samples");
  facts.emplace_back("truth",
                     truth.known() ? std::to_string(truth.poses.size()) + " poses" : "none");
  return facts;
}

Result<Doubt> run(const Options& o) {
  Doubt doubt;
  const auto data = read_data(o, doubt);
  if (!data) return data.error();
  const auto truth = o.read_truth(data->recording);
  if (!truth) return truth.error();
  std::vector<std::string> names;
  for (const Method* method : chosen(o)) names.push_back(method->name);
  if (auto ready = o.prepare(files_of(names)); !ready) return ready.error();
  MethodOutputs outputs{"Methods on " + o.log, {}, {}, *truth, facts_of(*data, *truth), doubt.why};
  run_all(o, *data, outputs);
  if (outputs.runs.empty())
    return Error{ErrorCode::not_found,
                 "no method can follow it; " + outputs.left_out.front().first + ": " +
                     outputs.left_out.front().second,
                 o.log};
  if (auto done = write_methods(o, outputs); !done) return done.error();
  if (o.quiet) return doubt;
  std::printf("%s%s\nreport: %s\n", to_text(outputs.facts).c_str(),
              to_text(tables_of(outputs)).c_str(), o.path("report.html").c_str());
  return doubt;
}

std::string footer() {
  std::string text = "Methods, and what they need:\n";
  for (const Method& method : methods()) {
    (text += "  ") += method.name;
    text.append(14 - method.name.size(), ' ') += method.title + ": " + method.inputs + "\n";
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine app(
      "Follow a recorded log by several methods with their defaults, and compare their paths in "
      "one "
      "table and one picture, with errors if true poses are known. A method whose data the log "
      "lacks is left out, with the reason.\nLOG is " +
      std::string(kRobotLogs) + ". Writes NAME.tum for each method, paths.svg and report.html.");
  app.footer(footer());
  Options o;
  app.add_file("LOG", o.log, "the recorded log").required();
  add_out(app, o);
  app.add_option("--methods", o.methods, "names separated by commas; by default all")
      .delimiter(',')
      .one_of(names_of_methods());
  o.truth.add_options(app);
  o.unit.add_options(app);
  app.add_flag("--no-unit", o.unit.none, "use no inertial unit, even if LOG has one");
  add_threads(app, o.threads);
  add_seed(app, o, kSeedHelp);
  add_robot_topics(app, o.topics);
  add_force_and_quiet(app, o);
  add_json(app, o);
  app.example("robot.log --out compared", "all methods for which the log has data");
  app.example("robot.bag --methods odometry,hector,graph --out compared",
              "three methods on a ROS recording");
  if (const auto code = app.parse(argc, argv)) return *code;
  return exit_code("compare_methods", run(o));
}
