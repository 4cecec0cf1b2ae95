#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <wayfare/core/result.hpp>

namespace wayfare::examples {

struct MonitorOptions {
  std::string recording = {};      ///< empty: that of the live logger
  std::string live = {};           ///< a logger's control socket or serial line; empty: none
  int baud = 57600;                ///< of that line
  std::string host = "127.0.0.1";  ///< address to listen on
  int port = 8090;                 ///< 0: any free port
  /// Other names by which browsers on this computer may address it, in small letters.
  std::vector<std::string> host_names = {};
  /// Required in every request. Empty: generated, and on a loopback address required by commands
  /// only.
  std::string token = {};
  /// Gets the token while the server runs, readable by this user only; empty: none.
  std::string token_file = {};
  std::size_t connections = 128;  ///< served concurrently; more wait
  std::size_t listeners = 32;     ///< to the live status; more are refused
  std::size_t queries = 4;        ///< short ones, and long ones, at the same time; more are refused
  double requests_per_s = 200.0;  ///< on average, with bursts of twice the number; more are refused
  double map_s = 600.0;           ///< duration of the recording used for the map
  double request_s = 5.0;         ///< to receive a request, while there are few connections
};

/// The monitor's web server; runs from `start` until its destruction.
class MonitorServer {
 public:
  [[nodiscard]] static Result<std::unique_ptr<MonitorServer>> start(MonitorOptions options);
  MonitorServer(const MonitorServer&) = delete;
  MonitorServer& operator=(const MonitorServer&) = delete;
  ~MonitorServer();

  [[nodiscard]] int port() const;
  [[nodiscard]] const std::string& token() const;
  /// What to open in a browser, with the token.
  [[nodiscard]] std::string url() const;

 private:
  struct Impl;
  explicit MonitorServer(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

/// The page it serves, with all it needs.
[[nodiscard]] const std::string& monitor_page();

}  // namespace wayfare::examples
