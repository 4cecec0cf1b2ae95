#pragma once

// Interface between the parts of a node that do not depend on ROS and the part that does.

#include <cstddef>
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

  /// `about` identifies the notice: a different text alone does not repeat it. The next
  /// error says how many were not repeated. `now_s` is of a monotonic clock.
  void add(Severity severity, const std::string& about, std::string text, double now_s) {
    const auto [last, is_new] = last_.try_emplace(about, Last{now_s});
    if (!is_new && now_s < last->second.said_s + again_s_) return void(++last->second.unsaid);
    if (severity == Severity::error && last->second.unsaid > 0)
      text += " (" + std::to_string(last->second.unsaid) + " more since)";
    last->second = {now_s};
    waiting_.push_back({severity, std::move(text)});
  }
  /// Those not taken yet.
  [[nodiscard]] std::vector<Notice> take() { return std::exchange(waiting_, {}); }

 private:
  struct Last {
    double said_s = 0.0;
    std::size_t unsaid = 0;  ///< since
  };
  double again_s_;
  std::map<std::string, Last> last_;
  std::vector<Notice> waiting_;
};

}  // namespace wayfare::ros
