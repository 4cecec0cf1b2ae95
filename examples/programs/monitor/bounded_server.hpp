#pragma once

// An HTTP server whose connections are bounded in memory and time before their requests are known.

#include <atomic>
#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <string>

#include <httplib.h>
#undef _res  // a macro of <resolv.h>, and a name in Eigen

namespace wayfare::examples {

struct ConnectionLimits {
  std::size_t request_bytes = 16384;  ///< of line, header and body
  std::size_t connections = 128;      ///< served concurrently; more wait
  std::size_t per_address = 32;       ///< of them, from one address that is not of this computer
  /// To receive a request, and to wait for the next one.
  std::chrono::milliseconds request_time{5000};
  /// The same while more than half of the connections are taken.
  std::chrono::milliseconds crowded_time{250};
  std::chrono::milliseconds write_time{5000};  ///< without progress
  /// On the way to a client, as far as the system permits: what a slow one gets is not old.
  int send_bytes = 131072;
};

/// httplib limits the length of a line, but not the number of lines and chunks nor their total
/// time, and keeps all of them until the request is complete.
class BoundedServer : public httplib::Server {
 public:
  explicit BoundedServer(const ConnectionLimits& limits);

  /// httplib listens with a backlog of five connections and has no option for it.
  void set_backlog(int connections);

 private:
  class Place;

  bool process_and_close_socket(socket_t socket) override;
  [[nodiscard]] std::chrono::milliseconds time() const;

  const ConnectionLimits limits_;
  std::atomic<std::size_t> taken_{0};
  std::mutex mutex_;
  std::map<std::string, std::size_t> by_address_;  // others than this computer's
};

}  // namespace wayfare::examples
