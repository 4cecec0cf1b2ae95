#include <wayfare/decode/rplidar_start.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <utility>

namespace wayfare::decode {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Pauses as in the maker's library, and times to answer beyond a host's buffers.
constexpr Duration kStopping = milliseconds(100), kResetting = seconds(1),
                   kMotor = milliseconds(10), kAnswer = milliseconds(500), kSpinUp = seconds(5),
                   kSilence = seconds(1), kFaulty = seconds(10);

/// High four bits of the model.
constexpr unsigned kFirstWithBoard = 2, kFirstNew = 4, kFirstWithMotor = 6;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Printable text up to the first zero.
std::string text_of(Bytes bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    if (byte == 0) break;
    if (byte >= 0x20 && byte < 0x7F) text += static_cast<char>(byte);
  }
  return text;
}

template <class... Values>
std::string format(const char* form, Values... values) {
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), form, values...);
  return text.data();
}

std::string health_text(const RplidarHealth& health) {
  if (health.status == RplidarHealth::Status::good) return "good";
  const char* name = health.status == RplidarHealth::Status::warning ? "warning" : "error";
  return name + format(" 0x%04x", health.code);
}

}  // namespace

std::string rplidar_model_name(std::uint8_t model) {
  struct Series {
    unsigned first;  ///< high four bits
    char letter;
    unsigned number;  ///< of the first
  };
  constexpr std::array<Series, 5> kSeries = {
      {{12, 'M', 1}, {9, 'T', 1}, {6, 'S', 1}, {4, 'C', 1}, {0, 'A', 0}}};
  const unsigned high = model >> 4U;
  const auto series = std::find_if(kSeries.begin(), kSeries.end(),
                                   [&](const Series& s) { return high >= s.first; });
  return format("%c%uM%u", series->letter, high - series->first + series->number, model & 0xFU);
}

std::string RplidarIdentity::text() const {
  std::string out;
  const auto add = [&](const std::string& part) { out += (out.empty() ? "" : ", ") + part; };
  if (info) {
    add(rplidar_model_name(info->model));
    add(format("firmware %u.%02u, hardware %u, serial number ", info->firmware_major,
               info->firmware_minor, info->hardware));
    for (const std::uint8_t byte : info->serial) out += format("%02X", byte);
  }
  if (health) add("health " + health_text(*health));
  if (!mode.empty()) add("mode " + mode);
  return out;
}

RplidarRequest RplidarStart::step(Bytes received, LogTime now) {
  if (step_ == Step::begin) return start_again(now);
  if (step_ != Step::stop && step_ != Step::reset)  // the rest of what was sent before
    decoder_.feed(received, [&](const RplidarPacket& packet) { take(packet, now); });
  if (answered_) return next(now);
  if (now < due_) return {};
  constexpr int kTries = 2;
  const bool asked = step_ >= Step::info && step_ <= Step::sample && step_ != Step::reset;
  if (asked && ++tries_ < kTries) {
    due_ = now + kAnswer;
    decoder_ = RplidarDecoder();
    return request_of(step_);
  }
  return next(now);
}

RplidarRequest RplidarStart::start_again(LogTime now) {
  state_ = State::starting;
  return go(Step::stop, now);
}

RplidarRequest RplidarStart::go(Step step, LogTime now) {
  step_ = step;
  answered_ = false;
  tries_ = 0;
  const Duration wait = step == Step::stop    ? kStopping
                        : step == Step::reset ? kResetting
                        : step == Step::motor ? kMotor
                                              : kAnswer;
  due_ = now + wait;
  decoder_ = step == Step::scan ? RplidarDecoder(RplidarFraming::running()) : RplidarDecoder();
  return request_of(step);
}

RplidarRequest RplidarStart::request_of(Step step) const {
  switch (step) {
    case Step::stop:
      return rplidar_stop();
    case Step::info:
      return rplidar_get_info();
    case Step::health:
      return rplidar_get_health();
    case Step::reset:
      return rplidar_reset();
    case Step::sample_rate:
      return rplidar_get_sample_rate();
    case Step::board:
      return rplidar_get_board_flags();
    case Step::rotation:
      return rplidar_get_conf(RplidarConfKey::desired_rotation);
    case Step::modes:
      return rplidar_get_conf(RplidarConfKey::mode_count);
    case Step::typical:
      return rplidar_get_conf(RplidarConfKey::typical_mode);
    case Step::name:
      return rplidar_get_conf(RplidarConfKey::mode_name, number_);
    case Step::answer:
      return rplidar_get_conf(RplidarConfKey::mode_response, number_);
    case Step::sample:
      return rplidar_get_conf(RplidarConfKey::mode_sample_us, number_);
    case Step::motor:
      if (series() >= kFirstWithMotor) return rplidar_motor_speed(rpm_);
      return pwm_ ? rplidar_motor_pwm(duty_) : RplidarRequest{};
    case Step::scan:
      return express_ ? rplidar_express_scan(static_cast<std::uint8_t>(number_)) : rplidar_scan();
    default:
      return {};
  }
}

void RplidarStart::take(const RplidarPacket& packet, LogTime now) {
  const RplidarResponse response = packet.response();
  if (is_rplidar_scan(response)) {
    identity_.scan = response;
    if (step_ == Step::scan) answered_ = true;
    if (packet.is_descriptor() || step_ < Step::running) return;
    due_ = now + kSilence;
    if (step_ == Step::running) state_ = State::scanning, trouble_.clear();
    return;
  }
  if (packet.is_descriptor()) return;
  const Bytes b = packet.bytes();
  if (response == RplidarResponse::info && step_ == Step::info) {
    identity_.info = rplidar_info(b);
    answered_ = true;
  } else if (response == RplidarResponse::health && step_ == Step::health) {
    identity_.health = rplidar_health(b);
    answered_ = true;
  } else if (response == RplidarResponse::sample_rate && step_ == Step::sample_rate) {
    answered_ = true;
  } else if (response == RplidarResponse::board_flags && step_ == Step::board) {
    pwm_ = (b[0] & 1) != 0;
    answered_ = true;
  } else if (response == RplidarResponse::conf) {
    if (const auto conf = rplidar_conf(b)) take_conf(*conf);
  }
}

void RplidarStart::take_conf(const RplidarConf& conf) {
  const Bytes v = conf.value;
  const auto is = [&](Step step, RplidarConfKey key, std::size_t least) {
    const bool expected = step_ == step && conf.key == key && v.size() >= least;
    answered_ = answered_ || expected;
    return expected;
  };
  if (is(Step::rotation, RplidarConfKey::desired_rotation, 4)) {
    rpm_ = load_le<std::uint16_t>(v.data());
    duty_ = load_le<std::uint16_t>(&v[2]);
  }
  if (is(Step::modes, RplidarConfKey::mode_count, 2)) modes_ = load_le<std::uint16_t>(v.data());
  if (is(Step::typical, RplidarConfKey::typical_mode, 2))
    number_ = load_le<std::uint16_t>(v.data());
  if (is(Step::name, RplidarConfKey::mode_name, 1)) identity_.mode = text_of(v);
  if (is(Step::answer, RplidarConfKey::mode_response, 1))
    identity_.scan = static_cast<RplidarResponse>(v[0]);
  is(Step::sample, RplidarConfKey::mode_sample_us, 4);
}

RplidarRequest RplidarStart::next(LogTime now) {
  switch (step_) {
    case Step::stop:
      identity_ = {};
      limitation_.clear();
      number_ = modes_ = 0;
      express_ = pwm_ = false;
      return go(Step::info, now);
    case Step::info:
      if (answered_) return go(Step::health, now);
      return give_up(State::unanswered, "no answer to requests", now);
    case Step::health:
      return after_health(now);
    case Step::reset:
      return start_again(now);
    case Step::sample_rate:
      if (series() >= kFirstWithBoard && series() < kFirstWithMotor) return go(Step::board, now);
      [[fallthrough]];
    case Step::board:
      if (has_modes() && series() >= kFirstWithBoard) return go(Step::rotation, now);
      [[fallthrough]];
    case Step::rotation:
      return choose(now);
    case Step::modes:
    case Step::typical:
      if (answered_) return go(Step::name, now);
      return standard(now, "it does not tell its scan modes");
    case Step::name:
      return after_name(now);
    case Step::answer:
      express_ = identity_.scan != RplidarResponse::node;
      if (!answered_ || !is_rplidar_scan(identity_.scan))
        return standard(now, "its mode " + identity_.mode + " has packets that are not decoded");
      return go(Step::sample, now);
    case Step::sample:
      return go(Step::motor, now);
    case Step::motor:
      return go(Step::scan, now);
    case Step::scan:
      if (!answered_ && express_) {
        express_ = false;
        limitation_ = "it does not start mode " + std::exchange(identity_.mode, "Standard");
        return go(Step::motor, now);
      }
      if (!answered_) return give_up(State::unanswered, "it does not start its scan", now);
      step_ = Step::running;
      answered_ = false;
      due_ = now + kSpinUp;
      return {};
    case Step::running:
      trouble_ = state_ == State::scanning ? "its scan has ended: started again"
                                           : "no measurements: does its motor turn?";
      return start_again(now);
    default:
      return start_again(now);
  }
}

RplidarRequest RplidarStart::after_health(LogTime now) {
  if (identity_.health && identity_.health->status == RplidarHealth::Status::error) {
    const std::string error = "it reports the error " + format("0x%04x", identity_.health->code);
    if (resets_++ == 0) {
      trouble_ = error + ": reset";
      return go(Step::reset, now);
    }
    resets_ = 0;
    return give_up(State::faulty, error + " after a reset", now);
  }
  resets_ = 0;
  if (identity_.health && identity_.health->status == RplidarHealth::Status::warning)
    limitation_ = "it reports the warning " + format("0x%04x", identity_.health->code);
  if (!has_firmware(1, 17)) return choose(now);
  return go(Step::sample_rate, now);
}

/// By number or name, or what the device has as default.
RplidarRequest RplidarStart::choose(LogTime now) {
  const std::string wanted = lower(wanted_);
  if (wanted == "standard") return standard(now, "");
  if (has_modes()) {
    unsigned number = 0;
    const char* end = wanted.data() + wanted.size();
    const auto read = std::from_chars(wanted.data(), end, number);
    number_ = 0;
    if (wanted == "typical") return go(Step::typical, now);
    if (read.ec != std::errc() || read.ptr != end || number > 255) return go(Step::modes, now);
    number_ = static_cast<std::uint16_t>(number);
    return go(Step::name, now);
  }
  if (!has_firmware(1, 17)) return standard(now, "");
  if (wanted != "typical" && wanted != "express")
    limitation_ = "its firmware has no mode " + wanted_;
  express_ = true;
  number_ = 0;
  identity_.mode = "Express";
  return go(Step::motor, now);
}

RplidarRequest RplidarStart::after_name(LogTime now) {
  if (modes_ == 0 || lower(identity_.mode) == lower(wanted_)) return go(Step::answer, now);
  if (++number_ < modes_) return go(Step::name, now);
  modes_ = 0;
  limitation_ = "it has no mode " + wanted_;
  return go(Step::typical, now);
}

RplidarRequest RplidarStart::standard(LogTime now, std::string limitation) {
  if (!limitation.empty()) limitation_ = std::move(limitation);
  express_ = false;
  number_ = 0;
  identity_.mode = "Standard";
  return go(has_modes() ? Step::sample : Step::motor, now);
}

RplidarRequest RplidarStart::give_up(State state, std::string trouble, LogTime now) {
  state_ = state;
  trouble_ = std::move(trouble);
  go(Step::waiting, now);
  due_ = now + (state == State::faulty ? kFaulty : kSilence);
  decoder_ = RplidarDecoder(RplidarFraming::running());
  return {};
}

unsigned RplidarStart::series() const {
  return identity_.info ? unsigned{identity_.info->model} >> 4U : 0U;
}

bool RplidarStart::motor_by_dtr() const { return identity_.info && series() < kFirstWithBoard; }

bool RplidarStart::has_firmware(unsigned major, unsigned minor) const {
  return identity_.info &&
         (identity_.info->firmware_major > major ||
          (identity_.info->firmware_major == major && identity_.info->firmware_minor >= minor));
}

bool RplidarStart::has_modes() const { return series() >= kFirstNew || has_firmware(1, 24); }

}  // namespace wayfare::decode
