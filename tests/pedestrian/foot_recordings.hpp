#pragma once

// Foot-mounted recordings, if available: PyShoe's with optical ground truth (Wagstaff et al. 2019)
// and OpenShoe's closed loops (Nilsson et al. 2012).

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <wayfare/io/text_file.hpp>
#include <wayfare/pedestrian/foot_tracker.hpp>
#include <wayfare/sensors/measurements.hpp>

namespace wayfare::testing {

struct FootRecording {
  std::vector<ImuSample> samples;
  std::vector<Eigen::Vector3d> truth;  ///< at the samples
};

/// Columns: specific force, angular rate, true position.
inline Result<FootRecording> read_foot(const std::string& path, double rate_hz) {
  const auto table = io::read_float_table(path);
  if (!table) return table.error();
  if (table->columns != 9) return Error{ErrorCode::invalid, "does not have nine columns", path};
  FootRecording r;
  for (std::size_t i = 0; i < table->rows(); ++i) {
    const auto row = table->row(i);
    const auto time = LogTime::from_nanoseconds(std::llround(1e9 * double(i) / rate_hz));
    r.samples.push_back(
        {time, Eigen::Vector3d(row[3], row[4], row[5]), Eigen::Vector3d(row[0], row[1], row[2])});
    // The optical system's axes are left-handed.
    r.truth.emplace_back(row[6], -row[7], row[8]);
  }
  return r;
}

inline std::string folder_of(const std::string& file) {
  return std::filesystem::path(file).parent_path().string();
}

inline std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& e : std::filesystem::directory_iterator(folder))
    if (e.path().extension() == ".gz") files.push_back(e.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

/// One pose per sample.
inline std::vector<FootPose> run_foot(const std::vector<ImuSample>& samples,
                                      const FootParameters& parameters) {
  FootTracker tracker(parameters);
  std::vector<FootPose> poses;
  const auto store = [&](const FootPose& p) { poses.push_back(p); };
  for (const ImuSample& s : samples) tracker.add(s, store);
  tracker.finish(store);
  return poses;
}

struct FootError {
  double end_m = 0.0, horizontal_m = 0.0;
};

/// At the end, after the rotation about the start that fits the truth best.
inline FootError end_error(const std::vector<FootPose>& poses, const FootRecording& r) {
  double along = 0.0, across = 0.0;
  const std::size_t skipped = r.samples.size() - poses.size();  // before the first attitude
  const auto off = [&](std::size_t i) -> Eigen::Vector3d {
    return r.truth[i + skipped] - r.truth[skipped];
  };
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d p = poses[i].position_m, t = off(i);
    along += p.x() * t.x() + p.y() * t.y();
    across += p.x() * t.y() - p.y() * t.x();
  }
  const SO3d rotation = SO3d::exp({0.0, 0.0, std::atan2(across, along)});
  const Eigen::Vector3d e = rotation * poses.back().position_m - off(poses.size() - 1);
  return {e.norm(), e.head<2>().norm()};
}

}  // namespace wayfare::testing
