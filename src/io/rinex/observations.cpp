#include <wayfare/io/observations.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include <wayfare/decode/ubx_messages.hpp>
#include <wayfare/gnss/gps_subframes.hpp>
#include <wayfare/io/rinex.hpp>

#include "io/columns/receiver_fixes.hpp"
#include "io/text/lines.hpp"

namespace wayfare::io {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::optional<GnssSystem> system_of(decode::UbxGnss gnss) {
  switch (gnss) {
    case decode::UbxGnss::gps:
      return GnssSystem::gps;
    case decode::UbxGnss::glonass:
      return GnssSystem::glonass;
    case decode::UbxGnss::galileo:
      return GnssSystem::galileo;
    case decode::UbxGnss::beidou:
      return GnssSystem::beidou;
    default:
      return std::nullopt;
  }
}

/// The carrier of the signal that is used of each system; nullopt for the others (signal
/// identifiers of table 1.5.4 of the interface description).
std::optional<double> carrier_of(GnssSystem system, const decode::UbxMeasurement& m) {
  const bool first = m.signal == 0 ||
                     (m.signal == 1 && system != GnssSystem::gps && system != GnssSystem::glonass);
  if (!first) return std::nullopt;
  switch (system) {
    case GnssSystem::glonass:
      return carrier::kGlonassL1 + m.glonass_channel * carrier::kGlonassL1Step;
    case GnssSystem::beidou:
      return carrier::kB1I;
    default:
      return carrier::kL1;
  }
}

std::optional<SatelliteObservation> observation_of(const decode::UbxMeasurement& m) {
  const auto system = system_of(m.gnss);
  if (!system || m.satellite < 1 || m.satellite > 63) return std::nullopt;
  const auto carrier_hz = carrier_of(*system, m);
  if (!carrier_hz || !m.pseudorange_valid || !std::isfinite(m.pseudorange_m)) return std::nullopt;
  SatelliteObservation o;
  o.satellite = {*system, static_cast<std::uint8_t>(m.satellite)};
  o.pseudorange_m = m.pseudorange_m;
  o.doppler_hz = std::isfinite(m.doppler_hz) ? double{m.doppler_hz} : kNone;
  const bool phase = m.carrier_phase_valid && std::isfinite(m.carrier_phase_cycles);
  o.carrier_cycles = phase ? m.carrier_phase_cycles : kNone;
  o.phase_interrupted = !m.half_cycle_resolved;
  o.cn0_dbhz = m.cn0_db_hz;
  o.carrier_hz = *carrier_hz;
  return o;
}

/// Collects a stream's messages.
class UbxStream {
 public:
  explicit UbxStream(std::string source) : source_(std::move(source)) {}

  void take(const decode::UbxMessage& m) {
    if (const auto raw = decode::rxm_rawx(m)) take(*raw, m.position());
    if (const auto frame = decode::rxm_sfrbx(m)) take(*frame);
  }

  Result<RawObservations> finish() {
    if (out_.epochs.empty())
      return Error{ErrorCode::parse, "contains no RXM-RAWX message with a range", source_};
    out_.ephemerides.gps_ionosphere = subframes_.ionosphere();
    out_.ephemerides.leap_seconds = subframes_.leap_seconds();
    return std::move(out_);
  }

 private:
  void take(const decode::UbxRawx& raw, std::uint64_t position) {
    const decode::UbxRawxEpoch epoch = raw.epoch();
    if (!(epoch.time_of_week_s >= 0.0 && epoch.time_of_week_s < 604800.0)) {
      out_.problems.add({ErrorCode::parse, "the time of week of a RXM-RAWX message is not one",
                         source_, 0, static_cast<std::size_t>(position)});
      return;
    }
    ObservationEpoch o{gps_time(epoch.week, from_seconds(epoch.time_of_week_s)), {}};
    for (std::size_t i = 0; i < raw.size(); ++i) {
      const auto one = observation_of(raw.measurement(i));
      const auto same = [&](const auto& other) { return other.satellite == one->satellite; };
      if (!one || std::any_of(o.satellites.begin(), o.satellites.end(), same)) continue;
      o.satellites.push_back(*one);
      const auto before = measured_.find(one->satellite);
      if (before == measured_.end() ||
          raw.measurement(i).lock_time_s < to_seconds(o.time - before->second))
        o.satellites.back().phase_interrupted = true;
      measured_[one->satellite] = o.time;
    }
    now_ = o.time;
    if (!o.satellites.empty()) out_.epochs.push_back(std::move(o));
  }

  /// Before the first epoch the week is not known.
  void take(const decode::UbxSubframe& frame) {
    const bool lnav = frame.gnss() == decode::UbxGnss::gps && frame.signal() == 0;
    if (!now_ || !lnav || frame.size() != GpsSubframes::kWords) return;
    GpsSubframe words{};
    for (std::size_t i = 0; i < words.size(); ++i) words[i] = frame.word(i) >> 6U & 0xFFFFFFU;
    if (const auto e = subframes_.add(frame.satellite(), words, *now_))
      if (const auto added = out_.ephemerides.add(Ephemeris(*e)); !added)
        out_.problems.add(added.error());
  }

  std::string source_;
  RawObservations out_;
  GpsSubframes subframes_;
  std::optional<Time<GpsClock>> now_;
  std::map<SatelliteId, Time<GpsClock>> measured_;  ///< newest time of each satellite
};

}  // namespace

Result<RawObservations> parse_observations(std::string_view bytes, const std::string& source) {
  if (!is_ubx(bytes)) {
    auto rinex = parse_rinex_observations(bytes, source);
    if (!rinex) return rinex.error();
    return RawObservations{std::move(rinex->epochs), {}, std::move(rinex->problems)};
  }
  UbxStream stream(source);
  const auto sink = [&](const decode::UbxMessage& m) { stream.take(m); };
  const auto decoder = std::make_unique<decode::UbxDecoder>();
  decoder->feed({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, sink);
  decoder->finish(sink);
  return stream.finish();
}

Result<RawObservations> read_observations(const std::string& path) {
  return read_and_parse(path, {}, parse_observations);
}

}  // namespace wayfare::io
