#include <wayfare/gnss/correct_ranges.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <variant>

#include <wayfare/gnss/ephemerides.hpp>
#include <wayfare/gnss/gps_time.hpp>
#include <wayfare/gnss/range_model.hpp>

namespace wayfare {
namespace {

/// Elevation- and signal-dependent part of a variance.
double variable_part(double elevation, double signal, double decade, double elevation_rad,
                     double cn0_dbhz) {
  const double cn0 = std::isfinite(cn0_dbhz) ? std::clamp(cn0_dbhz, 10.0, 65.0) : 45.0;
  const double low = elevation / std::max(std::sin(elevation_rad), 0.05);
  const double weak = signal * std::pow(10.0, (45.0 - cn0) / decade);
  return low * low + weak * weak;
}

/// The carrier of `o`; GLONASS channels are from the message.
double carrier_of(const SatelliteObservation& o, const Ephemeris& ephemeris) {
  const auto* glonass = std::get_if<GlonassEphemeris>(&ephemeris);
  const bool second = o.carrier_hz < 1.4e9;
  if (glonass != nullptr)
    return *carrier_hz(GnssSystem::glonass, second ? '2' : '1', glonass->channel);
  if (std::isfinite(o.carrier_hz) && o.carrier_hz > 0.0) return o.carrier_hz;
  return o.satellite.system == GnssSystem::beidou ? carrier::kB1I : carrier::kL1;
}

/// Corrects the satellites of one epoch.
class Corrector {
 public:
  Corrector(const ObservationEpoch& epoch, const Ephemerides& ephemerides,
            const Eigen::Vector3d& near_ecef_m, const RangeCorrectionOptions& options)
      : time_(epoch.time), ephemerides_(ephemerides), near_ecef_m_(near_ecef_m), options_(options) {
    known_ = near_ecef_m.allFinite() && near_ecef_m.norm() > 1e6 && near_ecef_m.norm() < 1e9;
    if (known_) near_ = geodetic_from_ecef(near_ecef_m);
  }

  /// The corrected range, or the reason for rejection.
  [[nodiscard]] std::variant<CorrectedRange, RangeRefusal> correct(
      const SatelliteObservation& o) const {
    if (const auto why = unusable(o)) return *why;
    // A rate without range still needs the satellite's state: 1 m/s of error per second of time.
    const double measured_m = std::isfinite(o.pseudorange_m) ? o.pseudorange_m : 2.3e7;
    const Time<GpsClock> transmission = time_ - from_seconds(measured_m / kSpeedOfLight_mps);
    const Ephemeris* ephemeris = ephemerides_.nearest(o.satellite, transmission);
    if (ephemeris == nullptr) return RangeRefusal::no_ephemeris;
    const Duration limit = options_.limits.age[index_of(o.satellite.system)];
    const Duration age = transmission - reference_time(*ephemeris);
    if (age > limit || age < -limit) return RangeRefusal::ephemeris_too_far;
    const double carrier = carrier_of(o, *ephemeris);
    if (!is_healthy(*ephemeris, carrier)) return RangeRefusal::unhealthy;
    const std::optional<double> delay_s = group_delay_s(*ephemeris, carrier);
    if (!delay_s) return RangeRefusal::unknown_signal;

    const double clock_s = satellite_state(*ephemeris, transmission).clock_s;
    const SatelliteState state = satellite_state(*ephemeris, transmission - from_seconds(clock_s));
    CorrectedRange range;
    range.satellite = o.satellite;
    range.cn0_dbhz = o.cn0_dbhz;
    rotate_to_reception(state, range);
    LineOfSight sight{0.0, 0.5};
    Air air;
    if (known_) {
      sight = line_of_sight(near_, range.position_ecef_m);
      if (sight.elevation_rad < options_.elevation_mask.radians()) return RangeRefusal::low;
      air = this->air(sight, carrier);
    }
    range.range_m = o.pseudorange_m + kSpeedOfLight_mps * (state.clock_s - *delay_s) -
                    air.delay_m;  // NaN stays NaN
    range.phase_m = o.carrier_cycles * kSpeedOfLight_mps / carrier +
                    kSpeedOfLight_mps * state.clock_s - (air.delay_m - 2.0 * air.ionosphere_m);
    range.phase_interrupted = o.phase_interrupted;
    range.phase_sigma_m = options_.sigma.phase_m(sight.elevation_rad);
    range.range_rate_mps =
        -o.doppler_hz * kSpeedOfLight_mps / carrier + kSpeedOfLight_mps * state.clock_drift;
    range.range_sigma_m = options_.sigma.range_m(sight.elevation_rad, o.cn0_dbhz, air.sigma_m);
    range.range_rate_sigma_mps = options_.sigma.rate_mps(sight.elevation_rad, o.cn0_dbhz);
    return range;
  }

 private:
  struct Air {
    double delay_m = 0.0;       ///< of the code
    double ionosphere_m = 0.0;  ///< part of it, by which the phase is advanced
    double sigma_m = 0.0;       ///< of the ionosphere after correction
  };

  [[nodiscard]] std::optional<RangeRefusal> unusable(const SatelliteObservation& o) const {
    if (!options_.systems[index_of(o.satellite.system)]) return RangeRefusal::not_wanted;
    const auto& excluded = options_.excluded;
    if (std::find(excluded.begin(), excluded.end(), o.satellite) != excluded.end())
      return RangeRefusal::not_wanted;
    if (!std::isfinite(o.pseudorange_m) && !std::isfinite(o.doppler_hz))
      return RangeRefusal::not_measured;
    // 20 000 km at the zenith to 42 000 km at the horizon, with a clock error of up to 100 ms.
    if (std::isfinite(o.pseudorange_m) && !(o.pseudorange_m > -1e7 && o.pseudorange_m < 7.5e7))
      return RangeRefusal::implausible;
    if (std::isfinite(o.cn0_dbhz) && o.cn0_dbhz < options_.min_cn0_dbhz) return RangeRefusal::weak;
    return std::nullopt;
  }

  /// Rotates the satellite into the Earth-fixed axes at reception (Sagnac effect). Its velocity is
  /// the derivative of the rotated position by the time of reception, as range rates require.
  void rotate_to_reception(const SatelliteState& s, CorrectedRange& range) const {
    constexpr double w = wgs84::kEarthRate_radps, c = kSpeedOfLight_mps;
    double travel_s = known_ ? (s.position_ecef_m - near_ecef_m_).norm() / c : 0.075;
    for (int i = 0; i < (known_ ? 2 : 1); ++i) {
      const double co = std::cos(w * travel_s), si = std::sin(w * travel_s);
      const Eigen::Matrix3d rotation =
          (Eigen::Matrix3d() << co, si, 0, -si, co, 0, 0, 0, 1).finished();
      range.position_ecef_m = rotation * s.position_ecef_m;
      range.velocity_ecef_mps = rotation * s.velocity_ecef_mps;
      if (known_) travel_s = (range.position_ecef_m - near_ecef_m_).norm() / c;
    }
    if (!known_) return;
    const Eigen::Vector3d u = (range.position_ecef_m - near_ecef_m_).normalized();
    const double travel_rate = u.dot(range.velocity_ecef_mps) / c;
    const Eigen::Vector3d& p = range.position_ecef_m;
    range.velocity_ecef_mps = (1.0 - travel_rate) * range.velocity_ecef_mps +
                              travel_rate * w * Eigen::Vector3d(p.y(), -p.x(), 0.0);
  }

  [[nodiscard]] Air air(const LineOfSight& sight, double carrier_hz) const {
    Air result;
    const auto& broadcast =
        ephemerides_.gps_ionosphere ? ephemerides_.gps_ionosphere : ephemerides_.beidou_ionosphere;
    if (options_.ionosphere) {
      result.delay_m = ionosphere_delay_m(broadcast ? *broadcast : nominal_ionosphere(), time_,
                                          near_, sight, carrier_hz);
      result.ionosphere_m = result.delay_m;
      result.sigma_m = result.delay_m * (broadcast ? options_.sigma.ionosphere_fraction
                                                   : options_.sigma.nominal_ionosphere_fraction);
    }
    if (options_.troposphere)
      result.delay_m += troposphere_delay_m(near_, sight, options_.relative_humidity);
    return result;
  }

  Time<GpsClock> time_;
  const Ephemerides& ephemerides_;
  Eigen::Vector3d near_ecef_m_;
  const RangeCorrectionOptions& options_;
  bool known_ = false;
  Geodetic near_;
};

}  // namespace

double RangeSigmaModel::range_m(double elevation_rad, double cn0_dbhz,
                                double unknown_ionosphere_m) const {
  const double variance =
      variable_part(elevation_m, signal_m, decade_dbhz, elevation_rad, cn0_dbhz);
  return scale *
         std::sqrt(floor_m * floor_m + unknown_ionosphere_m * unknown_ionosphere_m + variance);
}

double RangeSigmaModel::rate_mps(double elevation_rad, double cn0_dbhz) const {
  return scale * std::sqrt(rate_floor_mps * rate_floor_mps +
                           variable_part(rate_elevation_mps, rate_signal_mps, decade_dbhz,
                                         elevation_rad, cn0_dbhz));
}

double RangeSigmaModel::phase_m(double elevation_rad) const {
  return scale *
         std::hypot(phase_floor_m, phase_elevation_m / std::max(std::sin(elevation_rad), 0.05));
}

KlobucharModel nominal_ionosphere() {
  return {{2e-8, 0.0, 0.0, 0.0}, {1.1e5, 0.0, 0.0, 0.0}, carrier::kL1};
}

const char* to_text(RangeRefusal why) {
  constexpr const char* kTexts[] = {"neither range nor rate",
                                    "implausible range",
                                    "excluded",
                                    "duplicate in the epoch",
                                    "no ephemeris",
                                    "no ephemeris near enough in time",
                                    "unhealthy",
                                    "no group delay known for the signal",
                                    "below the elevation mask",
                                    "weak signal"};
  return kTexts[static_cast<std::size_t>(why)];
}

RangeEpoch correct_ranges(const ObservationEpoch& epoch, const Ephemerides& ephemerides,
                          const Eigen::Vector3d& near_ecef_m, const RangeCorrectionOptions& options,
                          std::vector<RefusedRange>* refused) {
  const Corrector corrector(epoch, ephemerides, near_ecef_m, options);
  RangeEpoch result{log_time(epoch.time), {}};
  std::vector<SatelliteId> seen;
  for (const SatelliteObservation& o : epoch.satellites) {
    const bool again = std::find(seen.begin(), seen.end(), o.satellite) != seen.end();
    seen.push_back(o.satellite);
    const auto corrected = again
                               ? std::variant<CorrectedRange, RangeRefusal>(RangeRefusal::duplicate)
                               : corrector.correct(o);
    if (const auto* range = std::get_if<CorrectedRange>(&corrected)) {
      result.satellites.push_back(*range);
    } else if (refused != nullptr) {
      refused->push_back({o.satellite, std::get<RangeRefusal>(corrected)});
    }
  }
  return result;
}

namespace {
constexpr double kPi = std::numbers::pi;
}

LineOfSight line_of_sight(const Geodetic& receiver, const Eigen::Vector3d& satellite_ecef_m) {
  const Eigen::Vector3d ned =
      rotation_ecef_ned(receiver).transpose() * (satellite_ecef_m - ecef_from_geodetic(receiver));
  const double azimuth = std::atan2(ned.y(), ned.x());
  return {azimuth < 0.0 ? azimuth + 2.0 * kPi : azimuth,
          std::atan2(-ned.z(), std::hypot(ned.x(), ned.y()))};
}

double ionosphere_delay_m(const KlobucharModel& model, Time<GpsClock> time,
                          const Geodetic& receiver, const LineOfSight& sight, double carrier_hz) {
  constexpr double kLayerHeight = 400e3;
  if (!(sight.elevation_rad > 0.0) || receiver.height_m > kLayerHeight) return 0.0;
  // The model is in semicircles.
  const double elevation = sight.elevation_rad / kPi;
  const double earth_angle = 0.0137 / (elevation + 0.11) - 0.022;
  const double latitude = std::clamp(
      receiver.latitude.radians() / kPi + earth_angle * std::cos(sight.azimuth_rad), -0.416, 0.416);
  const double longitude = receiver.longitude.radians() / kPi +
                           earth_angle * std::sin(sight.azimuth_rad) / std::cos(latitude * kPi);
  const double magnetic = latitude + 0.064 * std::cos((longitude - 1.617) * kPi);
  double local = std::fmod(43200.0 * longitude + to_seconds(week_time(time).of_week), 86400.0);
  if (local < 0.0) local += 86400.0;
  const auto cubic = [&](const std::array<double, 4>& c) {
    return c[0] + magnetic * (c[1] + magnetic * (c[2] + magnetic * c[3]));
  };
  const double amplitude = std::max(cubic(model.alpha), 0.0);
  const double period = std::max(cubic(model.beta), 72000.0);
  const double slant = 1.0 + 16.0 * std::pow(0.53 - elevation, 3);
  const double x = 2.0 * kPi * (local - 50400.0) / period;
  // The model prescribes this expansion of the cosine.
  const double day = std::abs(x) < 1.57 ? amplitude * (1.0 + x * x * (-0.5 + x * x / 24.0)) : 0.0;
  const double ratio = model.carrier_hz / carrier_hz;
  return kSpeedOfLight_mps * slant * (5e-9 + day) * ratio * ratio;
}

double zenith_troposphere_delay_m(const Geodetic& receiver, double relative_humidity) {
  const double height = receiver.height_m;
  if (height < -100.0 || height > 1e4) return 0.0;
  const double h = std::max(height, 0.0);
  const double pressure_hpa = 1013.25 * std::pow(1.0 - 2.2557e-5 * h, 5.2568);
  const double temperature_k = 15.0 - 6.5e-3 * h + 273.16;
  const double vapour_hpa = 6.108 * relative_humidity *
                            std::exp((17.15 * temperature_k - 4684.0) / (temperature_k - 38.45));
  const double hydrostatic =
      0.0022768 * pressure_hpa /
      (1.0 - 0.00266 * std::cos(2.0 * receiver.latitude.radians()) - 0.00028 * h / 1e3);
  const double wet = 0.002277 * (1255.0 / temperature_k + 0.05) * vapour_hpa;
  return hydrostatic + wet;
}

double troposphere_mapping(double elevation_rad) {
  const double s = std::sin(elevation_rad);
  return 1.001 / std::sqrt(0.002001 + s * s);
}

double troposphere_delay_m(const Geodetic& receiver, const LineOfSight& sight,
                           double relative_humidity) {
  if (!(sight.elevation_rad > 0.0)) return 0.0;
  return zenith_troposphere_delay_m(receiver, relative_humidity) *
         troposphere_mapping(sight.elevation_rad);
}

}  // namespace wayfare
