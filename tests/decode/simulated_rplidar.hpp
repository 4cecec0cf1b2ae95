#pragma once

// An RPLIDAR by the manual: it takes requests and sends responses and scans.

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/core/time.hpp>

#include "rplidar_streams.hpp"

namespace wayfare::decode {

class SimulatedRplidar {
 public:
  struct Mode {
    std::string name;
    RplidarResponse answer;
    double sample_us;
  };
  std::uint8_t model = 0x18, firmware_minor = 29;
  std::uint8_t health = 0;  ///< 0: good, 1: warning, 2: error
  bool reset_heals = true;  ///< a reset ends the error
  bool deaf = false;        ///< takes no request
  bool turning = true;      ///< else it measures nothing
  std::uint16_t typical = 1;
  std::vector<Mode> modes = {{"Standard", RplidarResponse::node, 508.0},
                             {"Express", RplidarResponse::express, 254.0}};
  std::uint8_t board = 1;        ///< flags of its adapter
  std::vector<int> commands;     ///< taken so far
  std::vector<Stream> requests;  ///< the same, all bytes
  int resets = 0;

  void take(Bytes bytes) {
    if (deaf) return;
    append(inbox_, {bytes.begin(), bytes.end()});
    while (!inbox_.empty()) {
      const bool has_payload = inbox_.size() > 1 && (inbox_[1] & 0x80) != 0;
      const std::size_t n = !has_payload ? 2 : inbox_.size() < 3 ? 3 : inbox_[2] + 4U;
      if (inbox_[0] != 0xA5 || inbox_.size() < n) break;
      const Stream request(inbox_.begin(), inbox_.begin() + static_cast<long>(n));
      inbox_.erase(inbox_.begin(), inbox_.begin() + static_cast<long>(n));
      obey(request);
    }
  }

  /// What it sends within `time`.
  Stream sent(Duration time) {
    Stream out = std::exchange(outbox_, {});
    if (scan_ == RplidarResponse::none || !turning) return out;
    const bool node_scan = scan_ == RplidarResponse::node;
    for (due_ += time; due_ >= period(); due_ -= period())
      append(out, node_scan ? next_node() : next_capsule());
    return out;
  }

  /// Its supply was interrupted.
  void reset() {
    ++resets;
    scan_ = RplidarResponse::none;
    const std::string banner =
        "RP LIDAR System.\r\nFirmware Ver 1.29 - rtm, HW Ver 7\r\nModel: 18\r\n";
    outbox_ = Stream(banner.begin(), banner.end());
    if (reset_heals) health = 0;
  }
  void scan(RplidarResponse answer) { scan_ = answer; }
  [[nodiscard]] bool scanning() const { return scan_ != RplidarResponse::none; }
  [[nodiscard]] std::size_t count(int command) const {
    return static_cast<std::size_t>(std::count(commands.begin(), commands.end(), command));
  }
  /// The last request of a command.
  [[nodiscard]] std::string request(int command) const {
    const auto last = std::find_if(requests.rbegin(), requests.rend(),
                                   [&](const Stream& r) { return r[1] == command; });
    return last == requests.rend() ? "" : hex(*last);
  }

 private:
  [[nodiscard]] Duration period() const {
    return std::chrono::microseconds(scan_ == RplidarResponse::node ? 500 : 8000);
  }
  Stream next_node() {
    const int i = std::exchange(index_, (index_ + 1) % 200);
    return node(i * 115, 4000 + i, 15, i == 0);
  }
  Stream next_capsule() {
    const int i = std::exchange(index_, (index_ + 1) % 200);
    return capsule(i * 20 % 360 * 64, Stream(80, 0x10), std::exchange(first_, false));
  }

  void reply(RplidarResponse response, const Stream& content) {
    append(outbox_, descriptor(response, static_cast<std::uint32_t>(content.size()), false));
    append(outbox_, content);
  }

  void begin(RplidarResponse answer) {
    append(outbox_, descriptor(answer, answer == RplidarResponse::node ? 5 : 84, true));
    scan_ = answer;
    first_ = true;
    index_ = 0;
    due_ = Duration(0);
  }

  void obey(const Stream& request) {
    commands.push_back(request[1]);
    requests.push_back(request);
    switch (request[1]) {
      case 0x25:
        scan_ = RplidarResponse::none;
        return;
      case 0x40:
        return reset();
      case 0x50: {
        Stream info = {model, firmware_minor, 1, 7};
        for (std::uint8_t i = 0; i < 16; ++i) info.push_back(static_cast<std::uint8_t>(0xA0 + i));
        return reply(RplidarResponse::info, info);
      }
      case 0x52:
        return reply(RplidarResponse::health, {health, 0x34, 0x12});
      case 0x59:
        return reply(RplidarResponse::sample_rate, {0xFC, 1, 0xFE, 0});
      case 0xFF:
        return reply(RplidarResponse::board_flags, {board, 0, 0, 0});
      case 0x20:
        return begin(RplidarResponse::node);
      case 0x82:
        if (firmware_minor < 24) return begin(RplidarResponse::express);
        return request[3] < modes.size() ? begin(modes[request[3]].answer) : void();
      case 0x84:
        return configuration(request);
      default:
        return;
    }
  }

  void configuration(const Stream& request) {
    if (firmware_minor < 24) return;
    Stream content = {request[3], request[4], request[5], request[6]};
    const std::size_t mode = request[2] >= 6 ? request[7] : 0U;
    const auto put = [&](std::uint32_t value, int bytes) {
      for (int i = 0; i < bytes; ++i) content.push_back(static_cast<std::uint8_t>(value >> 8 * i));
    };
    if (mode >= modes.size()) return;
    switch (request[3]) {
      case 0x01:
        put(630, 2), put(700, 2);
        break;
      case 0x70:
        put(static_cast<std::uint32_t>(modes.size()), 2);
        break;
      case 0x7C:
        put(typical, 2);
        break;
      case 0x71:
        put(static_cast<std::uint32_t>(modes[mode].sample_us * 256.0), 4);
        break;
      case 0x75:
        put(static_cast<std::uint32_t>(modes[mode].answer), 1);
        break;
      case 0x7F:
        content.insert(content.end(), modes[mode].name.begin(), modes[mode].name.end());
        content.push_back(0);
        break;
      default:
        return;
    }
    reply(RplidarResponse::conf, content);
  }

  Stream inbox_, outbox_;
  RplidarResponse scan_ = RplidarResponse::none;
  Duration due_{0};
  int index_ = 0;
  bool first_ = false;
};

}  // namespace wayfare::decode
