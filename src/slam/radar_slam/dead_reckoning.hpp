#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <wayfare/core/gaussian.hpp>
#include <wayfare/sync/augmented_scans.hpp>
#include <wayfare/system/radar_slam.hpp>

namespace wayfare {

/// Faults as they begin and end.
class FaultLog {
 public:
  /// Whether `what` is so at this time.
  void tell(const std::string& what, bool so, LogTime time);
  /// Those that lasted at least `shortest`, in order of their beginning.
  [[nodiscard]] std::vector<SensorFault> faults(Duration shortest) const;

 private:
  std::vector<SensorFault> all_;
  std::map<std::string, std::size_t> open_;
};

/// Step 4: the product of wheel and gyro model, with what is left of them when one fails.
class DeadReckoner {
 public:
  DeadReckoner(const DeadReckoningOptions& options, double wheel_base_m);

  [[nodiscard]] Gaussian<SE2d> increment(const SyncedStep& step, FaultLog& faults);

 private:
  enum class Stuck { none, left, right };
  [[nodiscard]] Stuck stuck(const SyncedStep& step);
  [[nodiscard]] Gaussian<SE2d> coasting(const SyncedStep& step, double dt) const;

  DeadReckoningOptions options_;
  double left_m_ = 0.0, right_m_ = 0.0, turned_rad_ = 0.0;  // since both wheels last rolled
  double speed_m_s_ = 0.0;
};

}  // namespace wayfare
