#pragma once

// Interface between the parts of a node that do not depend on ROS and the part that does.

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace wayfare::ros {

/// How a notice is logged.
enum class Severity {
  info,     ///< of what happens
  warning,  ///< of what is missing or was left out
  error,    ///< of what failed
};

/// A message for the node's user.
struct Notice {
  Severity severity = Severity::info;  ///< as logged
  std::string text;                    ///< in plain words
};

/// Notices, each repeated only after a while.
class Notices {
 public:
  /// The same notice is repeated after `again_s`.
  explicit Notices(double again_s = 10.0) : again_s_(again_s) {}

  /// `about` identifies the notice: a different text alone does not repeat it. `now_s` is of a
  /// monotonic clock.
  void add(Severity severity, const std::string& about, std::string text, double now_s) {
    const auto last = last_s_.find(about);
    if (last != last_s_.end() && now_s < last->second + again_s_) return;
    last_s_[about] = now_s;
    waiting_.push_back({severity, std::move(text)});
  }
  /// Those not taken yet.
  [[nodiscard]] std::vector<Notice> take() { return std::exchange(waiting_, {}); }

 private:
  double again_s_;
  std::map<std::string, double> last_s_;
  std::vector<Notice> waiting_;
};

}  // namespace wayfare::ros
