#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include <wayfare/core/result.hpp>

namespace wayfare::examples {

struct MonitorOptions {
  std::string recording = {};      ///< to be shown; empty: the live logger's own
  std::string live = {};           ///< a logger's control socket or line; empty: none
  std::string host = "127.0.0.1";  ///< address to listen on
  int port = 8090;                 ///< 0: any that is free
  /// Every request must carry it. Empty: none where the address is a loopback one, else one is made
  /// up.
  std::string token = {};
  std::size_t connections = 128;  ///< served at once; more wait
  std::size_t listeners = 32;     ///< to live status at once; more are refused
  std::size_t queries = 4;        ///< of a recording at once; more are refused
  double requests_per_s = 200.0;  ///< on average; more are refused, after twice as many at once
  double map_s = 600.0;           ///< of a recording that a map is made of
};

/// The monitor's web server, from `start` until it is gone.
class MonitorServer {
 public:
  [[nodiscard]] static Result<std::unique_ptr<MonitorServer>> start(MonitorOptions options);
  MonitorServer(const MonitorServer&) = delete;
  MonitorServer& operator=(const MonitorServer&) = delete;
  ~MonitorServer();

  [[nodiscard]] int port() const;
  [[nodiscard]] const std::string& token() const;
  /// What to open in a browser.
  [[nodiscard]] std::string url() const;

 private:
  struct Impl;
  explicit MonitorServer(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace wayfare::examples
