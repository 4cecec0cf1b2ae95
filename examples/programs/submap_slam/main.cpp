// Submap SLAM on a recorded log: local submaps, loop closure by branch and bound, pose adjustment.

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/eval/table.hpp>
#include <wayfare/slam/submap_slam.hpp>

#include "support/command_line.hpp"
#include "support/log_program.hpp"
#include "support/submap_slam_fields.hpp"

namespace {

using namespace wayfare;

Result<std::vector<std::uint8_t>> read_saved(const std::string& path) {
  if (path.empty()) return std::vector<std::uint8_t>();
  std::ifstream file(path, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file || bytes.empty()) return Error{ErrorCode::io, "cannot be read, or is empty", path};
  return bytes;
}

Result<void> save(const std::string& path, const std::vector<std::uint8_t>& bytes, bool force) {
  if (path.empty()) return {};
  if (!force && std::filesystem::exists(path))
    return Error{ErrorCode::io, "is there already; not overwritten", path};
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
  file.close();
  if (!file) return Error{ErrorCode::io, "cannot be written", path};
  return {};
}

struct Files {
  std::string from, to;  ///< saved maps
};

Result<examples::LogRun> run(const Recording& recording, SubmapSlamOptions options,
                             const Files& files, const examples::SlamArguments& arguments,
                             const SlamProgress& progress) {
  const auto saved = read_saved(files.from);
  if (!saved) return saved.error();
  options.threads = arguments.threads;
  auto slam = run_submap_slam(recording, options, progress, *saved);
  if (!slam) return slam.error();
  if (auto ok = save(files.to, slam->state, arguments.force); !ok) return ok.error();
  const SubmapSlamStatistics& s = slam->statistics;
  const double mebibytes = static_cast<double>(slam->memory_bytes) / (1 << 20);
  return examples::LogRun{
      std::move(slam->trajectory),
      std::move(slam->map),
      slam->graph,
      s.scans,
      s.unmatched_scans,
      {{"submaps", std::to_string(s.submaps) + " of " + std::to_string(s.nodes) + " scans"},
       {"graph", examples::size_of(slam->graph)},
       {"loop closures", std::to_string(s.loop_closures) + " accepted, " +
                             std::to_string(s.loops_refused) + " refused"},
       {"held", eval::fixed(mebibytes, 1) + " MiB"}},
      slam->refused_scans,
      slam->first_refusal};
}

}  // namespace

int main(int argc, char** argv) {
  SubmapSlamOptions options;
  Files files;
  return examples::run_log_program(
      argc, argv,
      {"submap_slam", "submap SLAM",
       "Correct the trajectory of a recorded robot log by submaps and loop closure and draw the "
       "map.",
       examples::submap_slam_fields(options),
       [&](const Recording& recording, const examples::SlamArguments& arguments,
           const SlamProgress& progress) {
         return run(recording, options, files, arguments, progress);
       },
       [&] { return examples::check_submap_slam(options); },
       [&](examples::CommandLine& app) {
         app.add_option("--continue", files.from,
                        "a map saved by an earlier run with the same options, to go on from; LOG "
                        "is what came after it")
             .existing_file();
         app.add_option("--save", files.to, "file to save the map to, to go on from later");
       }});
}
