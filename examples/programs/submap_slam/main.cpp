// Submap SLAM on a recorded log: local submaps, loop closure by branch and bound, pose-graph
// optimisation.

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/io/text_file.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "support/option_fields.hpp"
#include "support/slam_program.hpp"

namespace {

using namespace wayfare;
using namespace wayfare::examples;

Result<std::string> read_saved(const std::string& path) {
  if (path.empty()) return std::string();
  auto file = io::read_file(path, {std::size_t{1} << 40});
  if (!file) return file.error();
  if (file->bytes.empty()) return Error{ErrorCode::parse, "is empty", path};
  return std::move(file->bytes);
}

struct Files {
  std::string from, to;  ///< saved maps
};

Result<LogRun> run(SubmapSlamOptions options, const Files& files, const Recording& recording,
                   const SlamArguments& arguments, const SlamProgress& progress) {
  const auto saved = read_saved(files.from);
  if (!saved) return saved.error();
  options.threads = arguments.threads;
  auto slam =
      run_submap_slam(recording, options, progress,
                      {reinterpret_cast<const std::uint8_t*>(saved->data()), saved->size()});
  if (!slam) return slam.error();
  if (!files.to.empty()) {
    const std::string_view bytes(reinterpret_cast<const char*>(slam->state.data()),
                                 slam->state.size());
    if (auto ok = io::write_file(files.to, bytes, arguments.write()); !ok) return ok.error();
  }
  const SubmapSlamStatistics& s = slam->statistics;
  const double mebibytes = static_cast<double>(slam->memory_bytes) / (1 << 20);
  return log_run(
      *slam,
      {{"submaps", std::to_string(s.submaps) + " of " + std::to_string(s.nodes) + " scans"},
       {"graph", size_of(slam->graph)},
       {"loop closures", accepted_and_refused(s.loop_closures, s.loops_refused)},
       {"memory", eval::fixed(mebibytes, 1) + " MiB"}},
      slam->graph);
}

}  // namespace

int main(int argc, char** argv) {
  SubmapSlamOptions options;
  Files files;
  return run_log_program(
      argc, argv,
      {"submap_slam", "submap SLAM",
       "Estimate trajectory and map from a recorded robot log by submap SLAM with loop closure.",
       submap_slam_fields(options), std::bind_front(run, std::cref(options), std::cref(files)),
       [&] { return check_grid(options.grid); },
       [&](CommandLine& app) {
         app.add_file("--continue", files.from,
                      "a map saved by an earlier run with the same options, to continue; LOG is "
                      "the log after it");
         app.add_option("--save", files.to, "file to save the map to, for --continue")
             .shown_as("FILE");
         app.example("tuesday.log --continue monday.map --save both.map --out tuesday",
                     "goes on from the map that --save wrote before");
       }});
}
