#pragma once

#include <string>
#include <utility>
#include <vector>

#include <wayfare/nav/gnss_ins.hpp>

namespace wayfare::nav {

/// Innovations and notices; closed during replay.
struct EventLog {
  std::vector<InnovationRecord> innovations;
  std::vector<GnssInsNotice> notices;
  bool open = true;

  void note(LogTime time, std::string text, bool lost = false) {
    if (open) notices.push_back({time, std::move(text), lost});
  }
};

}  // namespace wayfare::nav
