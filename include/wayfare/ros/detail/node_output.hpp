#pragma once

// What the parts of a node that do not know ROS hand to the part that does.

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace wayfare::ros {

enum class Severity { info, warning, error };

/// Something a node's user should read.
struct Notice {
  Severity severity = Severity::info;
  std::string text;
};

/// Notices, each told again only after a while.
class Notices {
 public:
  explicit Notices(double again_s = 10.0) : again_s_(again_s) {}

  /// `about` names the occasion: what differs in the text alone is not told anew. `now_s` is of a
  /// clock that does not go back.
  void tell(Severity severity, const std::string& about, std::string text, double now_s) {
    const auto told = told_s_.find(about);
    if (told != told_s_.end() && now_s < told->second + again_s_) return;
    told_s_[about] = now_s;
    waiting_.push_back({severity, std::move(text)});
  }
  /// Those not taken yet.
  [[nodiscard]] std::vector<Notice> take() { return std::exchange(waiting_, {}); }

 private:
  double again_s_;
  std::map<std::string, double> told_s_;
  std::vector<Notice> waiting_;
};

}  // namespace wayfare::ros
