// Fixes of receivers' streams: NAV-PVT of u-blox, GGA and RMC of NMEA 0183.

#include "io/columns/receiver_fixes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include <wayfare/core/detail/bytes.hpp>
#include <wayfare/decode/nmea.hpp>
#include <wayfare/decode/ubx_messages.hpp>
#include <wayfare/gnss/gps_time.hpp>

#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

/// Of its beginning, in which the kind of a stream shows.
constexpr std::size_t kBeginning = 1U << 16U;

decode::Bytes as_bytes(std::string_view bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

template <class Decoder, class Sink>
decode::DecoderStatistics decode_all(std::string_view bytes, const Sink& sink) {
  const auto decoder = std::make_unique<Decoder>();
  decoder->feed(as_bytes(bytes), sink);
  decoder->finish(sink);
  return decoder->statistics();
}

template <class Decoder>
bool has_frames(std::string_view bytes) {
  const auto ignore = [](const auto&) {};
  return decode_all<Decoder>(bytes.substr(0, kBeginning), ignore).frames > 0;
}

Eigen::Matrix3d diagonal(double horizontal_sigma, double vertical_sigma) {
  const double h = horizontal_sigma * horizontal_sigma / 2.0;
  return Eigen::Vector3d(h, h, vertical_sigma * vertical_sigma).asDiagonal();
}

/// GPS time of the epoch. The time of week does not depend on leap seconds, which a receiver may
/// not know yet; the fraction of the second is more exact in UTC.
std::optional<LogTime> time_of(const decode::UbxPvt& p) {
  if (!p.date_valid || !p.time_valid) return std::nullopt;
  const auto utc = utc_from_civil(
      {p.year, p.month, p.day, p.hour, p.minute, std::chrono::seconds(std::min(p.second, 60))});
  if (!utc) return std::nullopt;
  const Time<GpsClock> by_utc = to_gps(*utc) + std::chrono::nanoseconds(p.nanosecond);
  const auto of_week = std::chrono::milliseconds(std::llround(1e3 * p.time_of_week_s));
  const Time<GpsClock> by_week = nearest_time_of_week(of_week, by_utc);
  const Duration apart = by_utc - by_week;
  return log_time(std::max(apart, -apart) < std::chrono::milliseconds(1) ? by_utc : by_week);
}

/// RTKLIB's numbers of quality.
int quality_of(const decode::UbxPvt& p) {
  if (p.carrier_solution == 2) return 1;
  if (p.carrier_solution == 1) return 2;
  return p.differential ? 4 : 5;
}

std::optional<GnssFix> fix_of(const decode::UbxPvt& p) {
  const auto time = time_of(p);
  const bool position = p.fix_ok && p.fix_type >= 2 && p.fix_type <= 4;
  const bool sigmas = p.horizontal_sigma_m > 0.0 && p.vertical_sigma_m > 0.0;
  if (!time || !position || !sigmas || std::abs(p.latitude_deg) > 90.0) return std::nullopt;
  GnssFix fix;
  fix.time = *time;
  fix.position = {Angle::degrees(p.latitude_deg), Angle::degrees(p.longitude_deg), p.height_m};
  fix.position_covariance_ned_m2 = diagonal(p.horizontal_sigma_m, p.vertical_sigma_m);
  if (p.speed_sigma_mps > 0.0) {
    const auto& v = p.velocity_ned_mps;
    fix.velocity_ned_mps = Eigen::Vector3d(v[0], v[1], v[2]);
    fix.velocity_covariance_ned =
        p.speed_sigma_mps * p.speed_sigma_mps * Eigen::Matrix3d::Identity();
  }
  return fix;
}

/// Pairs the GGA and RMC sentences of an epoch, which gives the date.
class NmeaEpochs {
 public:
  explicit NmeaEpochs(FixFile& file) : file_(file) {}

  void take(const decode::NmeaSentence& s) {
    if (const auto fix = decode::nmea_gga(s)) {
      begin(fix->time_of_day_s);
      fix_ = *fix;
    } else if (const auto motion = decode::nmea_rmc(s)) {
      begin(motion->time_of_day_s);
      motion_ = *motion;
    }
  }
  void finish() { begin(-1.0); }
  [[nodiscard]] std::size_t undated() const { return undated_; }

 private:
  void begin(double time_of_day_s) {
    if (time_of_day_s == time_of_day_s_) return;
    if (motion_)
      date_ = std::array{motion_->year, motion_->month, motion_->day};
    else if (time_of_day_s_ >= 0.0 && time_of_day_s_ + 43200.0 < last_s_)
      date_.reset();  // after midnight the next RMC gives the date
    if (time_of_day_s_ >= 0.0) last_s_ = time_of_day_s_;
    if (fix_) emit();
    fix_.reset(), motion_.reset();
    time_of_day_s_ = time_of_day_s;
  }

  void emit() {
    constexpr std::array kQuality = {0, 5, 4, 5, 1, 2};  // RTKLIB's, of GGA's
    constexpr std::array kSigma_m = {0.0, 3.0, 1.5, 3.0, 0.02, 0.3};
    const auto q = static_cast<std::size_t>(fix_->quality);
    if (q == 0 || q >= kQuality.size() || !fix_->height_above_sea_m) return;
    const auto time = epoch_time();
    if (!time) {
      ++undated_;
      return;
    }
    GnssFix fix;
    fix.time = *time;
    fix.position = {Angle::degrees(fix_->latitude_deg), Angle::degrees(fix_->longitude_deg),
                    *fix_->height_above_sea_m + fix_->geoid_m.value_or(0.0)};
    constexpr double kHighest_m = 1e7;
    if (!(std::abs(fix.position.height_m) < kHighest_m)) return;
    const double sigma_m = kSigma_m.at(q) * std::clamp(fix_->hdop.value_or(1.0), 0.5, 50.0);
    fix.position_covariance_ned_m2 = diagonal(sigma_m, 1.5 * sigma_m);
    add_velocity(fix);
    file_.fixes.push_back(fix);
    file_.qualities.push_back(kQuality.at(q));
  }

  [[nodiscard]] std::optional<LogTime> epoch_time() const {
    if (!date_) return std::nullopt;
    const auto [year, month, day] = *date_;
    const auto midnight = utc_from_civil({year, month, day, 0, 0, {}});
    if (!midnight) return std::nullopt;
    return log_time(to_gps(*midnight + from_seconds(time_of_day_s_)));
  }

  /// Horizontal, from speed and course; the climb is not known.
  void add_velocity(GnssFix& fix) const {
    if (!motion_ || !motion_->valid || !motion_->speed_mps) return;
    const double speed = *motion_->speed_mps;
    const bool moves = motion_->course_deg.has_value();
    constexpr double kFastest_mps = 1e4;
    if (speed < 0.0 || speed > kFastest_mps || (!moves && speed > 0.5)) return;
    const double course = Angle::degrees(motion_->course_deg.value_or(0.0)).radians();
    fix.velocity_ned_mps = {speed * std::cos(course), speed * std::sin(course), 0.0};
    const double vertical = std::hypot(0.3, 0.05 * speed);  // a slope of three degrees
    fix.velocity_covariance_ned = Eigen::Vector3d(0.09, 0.09, vertical * vertical).asDiagonal();
  }

  FixFile& file_;
  std::optional<decode::NmeaFix> fix_;
  std::optional<decode::NmeaMotion> motion_;
  std::optional<std::array<int, 3>> date_;
  double time_of_day_s_ = -1.0, last_s_ = -1.0;
  std::size_t undated_ = 0;
};

}  // namespace

bool is_ubx(std::string_view bytes) {
  const bool sync = bytes.substr(0, kBeginning).find("\xB5\x62") != bytes.npos;
  return sync && has_frames<decode::UbxDecoder>(bytes);
}

bool is_nmea(std::string_view bytes) {
  const bool start = bytes.substr(0, kBeginning).find_first_of("$!") != bytes.npos;
  return start && has_frames<decode::NmeaDecoder>(bytes);
}

Result<FixFile> parse_receiver_fixes(std::string_view bytes, const std::string& source) {
  FixFile file;
  std::size_t pvt = 0;
  decode_all<decode::UbxDecoder>(bytes, [&](const decode::UbxMessage& m) {
    const auto message = decode::nav_pvt(m);
    if (!message) return;
    ++pvt;
    if (auto fix = fix_of(*message)) {
      file.fixes.push_back(*std::move(fix));
      file.qualities.push_back(quality_of(*message));
    }
  });
  if (!file.fixes.empty()) return file;
  NmeaEpochs epochs(file);
  decode_all<decode::NmeaDecoder>(bytes, [&](const auto& sentence) { epochs.take(sentence); });
  epochs.finish();
  if (!file.fixes.empty()) return file;
  std::string what = "contains no fix";
  if (pvt > 0) what += ": none of its " + std::to_string(pvt) + " NAV-PVT messages has one";
  if (epochs.undated() > 0)
    what += ": " + std::to_string(epochs.undated()) + " GGA sentences without an RMC for the date";
  return Error{ErrorCode::parse, what, source};
}

}  // namespace wayfare::io
