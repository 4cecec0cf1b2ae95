#pragma once

// The command line of fastdds_peer; its options are described there.

#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace peer {

struct Options {
  std::vector<std::string> words;  ///< mode and what it needs
  bool best_effort = false, transient_local = false, every_interface = false, raw = false;
  int depth = 1000, domain = 0, wait_for = 0, late_readers = 0;
  std::uint32_t count = 10, size = 0;
  double period_s = 0.02, stay_s = 0.0, timeout_s = 20.0, speed = 1.0;
};

inline Options options_of(int argc, char** argv) {
  Options o;
  if (const char* domain = std::getenv("ROS_DOMAIN_ID")) o.domain = std::atoi(domain);
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto number = [&] {
      if (i + 1 == argc) throw std::invalid_argument(word + " needs a number");
      return std::stod(argv[++i]);
    };
    if (word == "--best-effort")
      o.best_effort = true;
    else if (word == "--transient-local")
      o.transient_local = true;
    else if (word == "--every-interface")
      o.every_interface = true;
    else if (word == "--raw")
      o.raw = true;
    else if (word == "--depth")
      o.depth = static_cast<int>(number());
    else if (word == "--domain")
      o.domain = static_cast<int>(number());
    else if (word == "--wait-for")
      o.wait_for = static_cast<int>(number());
    else if (word == "--late-readers")
      o.late_readers = static_cast<int>(number());
    else if (word == "--count")
      o.count = static_cast<std::uint32_t>(number());
    else if (word == "--size")
      o.size = static_cast<std::uint32_t>(number());
    else if (word == "--period-ms")
      o.period_s = 1e-3 * number();
    else if (word == "--stay-s")
      o.stay_s = number();
    else if (word == "--timeout-s")
      o.timeout_s = number();
    else if (word == "--speed")
      o.speed = number();
    else if (word.rfind("--", 0) == 0)
      throw std::invalid_argument("no option " + word);
    else
      o.words.push_back(word);
  }
  return o;
}

}  // namespace peer
