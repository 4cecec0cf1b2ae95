#pragma once

// Identification and start of a SLAMTEC RPLIDAR by its protocol, in the order of the maker's
// library (Slamtec/rplidar_sdk): stop, identity, health, sample times, scan mode, motor, scan.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/core/time.hpp>
#include <wayfare/decode/rplidar_conf.hpp>
#include <wayfare/decode/rplidar_decoder.hpp>
#include <wayfare/decode/rplidar_protocol.hpp>

namespace wayfare::decode {

/// What an RPLIDAR reported about itself, and its scan.
struct RplidarIdentity {
  std::optional<RplidarInfo> info;               ///< model, firmware, serial number
  std::optional<RplidarHealth> health;           ///< state
  std::string mode = {};                         ///< name of the scan mode
  RplidarResponse scan = RplidarResponse::none;  ///< the scan's packets

  /// In words: "A1M8, firmware 1.29, hardware 7, serial number …, health good, mode Boost".
  [[nodiscard]] std::string text() const;
};

/// The series and variant of a model, such as A1M8.
[[nodiscard]] std::string rplidar_model_name(std::uint8_t model);

/// Identifies an RPLIDAR and starts its scan; again, where no packet of a scan arrived for a
/// second, as after a reset or where the line was replugged, or for five once it was asked for. A
/// device that reports an error is reset. One that does not answer but scans is left alone.
///
/// It sends and receives nothing itself: pass the bytes received to `step`, send what it returns.
class RplidarStart {
 public:
  /// What it does now.
  enum class State {
    starting,    ///< asks, or waits for the scan to begin
    scanning,    ///< packets of the scan arrive
    unanswered,  ///< no answer to requests: asks again after a second without packets of a scan
    faulty,      ///< the device reports an error after a reset, too: asks again in ten seconds
  };

  /// `mode`: "typical", the device's default; "standard", single nodes; or the name or the number
  /// of one of its modes (firmware 1.24 and later).
  explicit RplidarStart(std::string mode = "typical") : wanted_(std::move(mode)) {}

  /// Takes the bytes received up to `now` and returns what is to be sent now, mostly nothing. To be
  /// called every 20 ms while it starts, and four times a second at least.
  [[nodiscard]] RplidarRequest step(Bytes received, LogTime now);
  /// The line was opened: begins with the next step.
  void restart() { step_ = Step::begin; }

  [[nodiscard]] State state() const { return state_; }  ///< by the last step
  /// Whether the motor depends on the line DTR, which has to be off: the device is an A1.
  [[nodiscard]] bool motor_by_dtr() const;
  /// As far as it was reported.
  [[nodiscard]] const RplidarIdentity& identity() const { return identity_; }
  /// Reason why there is no scan, or why not in the mode that was asked for; empty: none.
  [[nodiscard]] const std::string& problem() const {
    return trouble_.empty() ? limitation_ : trouble_;
  }

 private:
  enum class Step {
    begin,
    stop,
    info,
    health,
    reset,
    sample_rate,
    board,
    rotation,
    modes,
    typical,
    name,
    answer,
    sample,
    motor,
    scan,
    running,
    waiting,
  };

  void take(const RplidarPacket& packet, LogTime now);
  void take_conf(const RplidarConf& conf);
  RplidarRequest go(Step step, LogTime now);
  [[nodiscard]] RplidarRequest request_of(Step step) const;
  RplidarRequest next(LogTime now);
  RplidarRequest after_health(LogTime now);
  RplidarRequest choose(LogTime now);
  RplidarRequest after_name(LogTime now);
  RplidarRequest standard(LogTime now, std::string limitation);
  RplidarRequest start_again(LogTime now);
  RplidarRequest give_up(State state, std::string trouble, LogTime now);
  [[nodiscard]] unsigned series() const;
  [[nodiscard]] bool has_firmware(unsigned major, unsigned minor) const;
  [[nodiscard]] bool has_modes() const;

  std::string wanted_;
  RplidarDecoder decoder_;
  Step step_ = Step::begin;
  State state_ = State::starting;
  LogTime due_;  ///< when an answer is missing, or a wait is over
  bool answered_ = false;
  int tries_ = 0, resets_ = 0;
  bool express_ = false;                  ///< the scan is of capsules
  std::uint16_t number_ = 0;              ///< of the mode
  std::uint16_t modes_ = 0;               ///< how many there are
  std::uint16_t rpm_ = 600, duty_ = 660;  ///< of the motor, the maker's defaults
  bool pwm_ = false;                      ///< the adapter board controls the motor
  RplidarIdentity identity_;
  std::string trouble_, limitation_;
};

}  // namespace wayfare::decode
