// Messages of u-blox receivers, written by our encoder, as RTKLIB's library and our decoder read
// them.

#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <wayfare/core/random.hpp>
#include <wayfare/io/observations.hpp>
#include "io/support.hpp"
#include "rtklib.hpp"
#include "subframe_writer.hpp"

namespace wayfare {
namespace {

using decode::UbxBytes;

constexpr int kUbxFormat = 3, kEphStride = 304;
constexpr int kGps = 0x01, kGalileo = 0x08;

/// RTKLIB's decoder.
class Peer {
 public:
  Peer() : raw_(std::make_unique<raw_t>()) {
    if (init_raw(raw_.get(), kUbxFormat) != 1) ADD_FAILURE() << "init_raw";
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  ~Peer() { free_raw(raw_.get()); }

  /// What the last byte of the message gave: 1 observations, 2 an ephemeris.
  int take(const UbxBytes& bytes) {
    int status = 0;
    for (const std::uint8_t byte : bytes) status = input_ubx(raw_.get(), byte);
    return status;
  }
  [[nodiscard]] std::vector<obsd_t> observations() const {
    return {raw_->data, raw_->data + raw_->n};
  }
  [[nodiscard]] eph_t ephemeris(int satellite) const {
    eph_t e{};
    std::memcpy(&e, raw_->eph + (satellite - 1) * kEphStride, kEphStride);
    return e;
  }

 private:
  std::unique_ptr<raw_t> raw_;
};

/// GPS and Galileo of many values.
std::vector<decode::UbxMeasurement> measurements(Rng& rng) {
  std::vector<decode::UbxMeasurement> all;
  for (int i = 0; i < 20; ++i) {
    decode::UbxMeasurement m = decode::sample_measurements()[i % 2 == 0 ? 0 : 1];
    m.satellite = 1 + i;
    m.pseudorange_m = 2e7 + 1e7 * rng.uniform();
    m.carrier_phase_cycles = m.pseudorange_m * 5.25;
    m.doppler_hz = static_cast<float>(8000.0 * rng.uniform() - 4000.0);
    m.cn0_db_hz = 20 + static_cast<int>(rng.below(35));
    m.lock_time_s = 10.0;
    m.carrier_phase_sigma_cycles = 0.008;
    m.pseudorange_valid = m.carrier_phase_valid = m.half_cycle_resolved = true;
    m.half_cycle_subtracted = false;
    all.push_back(m);
  }
  return all;
}

TEST(RtklibUbx, SameRangesPhasesDopplersAndStrengths) {
  Rng rng(7);
  Peer peer;
  UbxBytes stream;
  std::vector<std::vector<obsd_t>> theirs;
  for (int epoch = 0; epoch < 50; ++epoch) {
    const UbxBytes bytes =
        decode::rawx({1000.25 + epoch, 2381, 18, true, false}, measurements(rng));
    decode::append_bytes(stream, bytes);
    ASSERT_EQ(peer.take(bytes), 1);
    theirs.push_back(peer.observations());
  }
  const auto ours =
      io::parse_observations({reinterpret_cast<const char*>(stream.data()), stream.size()}, "x");
  ASSERT_TRUE(ours) << ours.error().to_string();
  ASSERT_EQ(ours->epochs.size(), theirs.size());
  for (std::size_t i = 0; i < theirs.size(); ++i) {
    const ObservationEpoch& epoch = ours->epochs[i];
    ASSERT_EQ(theirs[i].size(), 20U);
    ASSERT_EQ(epoch.satellites.size(), 20U);
    const gtime_t t =
        gpst2time(week_time(epoch.time).week, to_seconds(week_time(epoch.time).of_week));
    for (const SatelliteObservation& o : epoch.satellites) {
      const int system = o.satellite.system == GnssSystem::gps ? kGps : kGalileo;
      const int number = satno(system, o.satellite.number);
      const auto same = std::find_if(theirs[i].begin(), theirs[i].end(),
                                     [&](const obsd_t& d) { return d.sat == number; });
      ASSERT_NE(same, theirs[i].end());
      EXPECT_EQ(same->P[0], o.pseudorange_m);
      EXPECT_EQ(same->L[0], o.carrier_cycles);
      EXPECT_EQ(double{same->D[0]}, o.doppler_hz);
      EXPECT_EQ(same->SNR[0], std::lround(1e3 * o.cn0_dbhz));
      EXPECT_EQ(same->time.time, t.time);
      EXPECT_NEAR(same->time.sec, t.sec, 1e-7);
    }
  }
}

TEST(RtklibUbx, SameEphemeris) {
  Peer peer;
  const KeplerianEphemeris sent = tests::sample_ephemeris();
  UbxBytes stream = decode::rawx({410000.0, 2381, 18, true, false}, decode::sample_measurements());
  peer.take(stream);
  int status = 0;
  for (const GpsSubframe& words : tests::subframes_of(sent)) {
    const UbxBytes bytes = tests::sfrbx(17, words);
    status = peer.take(bytes);
    decode::append_bytes(stream, bytes);
  }
  ASSERT_EQ(status, 2);
  const auto ours =
      io::parse_observations({reinterpret_cast<const char*>(stream.data()), stream.size()}, "x");
  ASSERT_TRUE(ours) << ours.error().to_string();
  ASSERT_EQ(ours->ephemerides.size(), 1U);
  const auto& e = std::get<KeplerianEphemeris>(ours->ephemerides.of(sent.satellite).front());
  const eph_t p = peer.ephemeris(satno(kGps, 17));
  EXPECT_EQ(p.iode, e.issue);
  EXPECT_EQ(p.svh, e.health);
  EXPECT_EQ(p.week, week_time(e.toe).week);
  EXPECT_DOUBLE_EQ(p.toes, to_seconds(week_time(e.toe).of_week));
  const double ours_of[] = {e.sqrt_semi_major_axis * e.sqrt_semi_major_axis,
                            e.eccentricity,
                            e.inclination_rad,
                            e.ascending_node_rad,
                            e.argument_of_perigee_rad,
                            e.mean_anomaly_rad,
                            e.mean_motion_difference_radps,
                            e.ascending_node_rate_radps,
                            e.inclination_rate_radps,
                            e.crc_m,
                            e.crs_m,
                            e.cuc_rad,
                            e.cus_rad,
                            e.cic_rad,
                            e.cis_rad,
                            e.clock_bias_s,
                            e.clock_drift,
                            e.clock_drift_rate_per_s};
  const double theirs_of[] = {p.A,   p.e,   p.i0,  p.OMG0, p.omg, p.M0,  p.deln, p.OMGd, p.idot,
                              p.crc, p.crs, p.cuc, p.cus,  p.cic, p.cis, p.f0,   p.f1,   p.f2};
  for (std::size_t i = 0; i < std::size(ours_of); ++i)
    EXPECT_NEAR(ours_of[i], theirs_of[i], 1e-14 * std::abs(theirs_of[i])) << i;
}

}  // namespace
}  // namespace wayfare
