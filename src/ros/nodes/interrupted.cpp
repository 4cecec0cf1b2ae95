#include <atomic>
#include <csignal>

#include <wayfare/ros/detail/raw_node.hpp>

namespace wayfare::ros {
namespace {

std::atomic<bool> received{false};

}  // namespace

bool interrupted() {
  static const bool handled = [] {
    for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { received = true; });
    return true;
  }();
  return handled && received;
}

}  // namespace wayfare::ros
