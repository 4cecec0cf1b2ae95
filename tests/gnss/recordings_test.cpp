// Single-point positioning of whole recordings against their references.

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <wayfare/gnss/single_point.hpp>
#include <wayfare/io/nav_text.hpp>
#include <wayfare/io/rinex.hpp>
#include "io/support.hpp"

namespace wayfare {
namespace {

const std::string kSpirent = "gnss/instinct_spirent_dyn/";

Ephemerides messages_of(const std::vector<std::string>& names) {
  Ephemerides all;
  for (const std::string& name : names) {
    const auto nav = io::read_rinex_navigation(testing::recording(name));
    EXPECT_TRUE(nav) << nav.error().to_string();
    if (nav) all.add(nav->ephemerides);
  }
  return all;
}

std::vector<ObservationEpoch> epochs_of(const std::string& path) {
  auto obs = io::read_rinex_observations(path);
  EXPECT_TRUE(obs) << obs.error().to_string();
  return obs ? std::move(obs->epochs) : std::vector<ObservationEpoch>{};
}

/// Root mean square errors of a run.
struct Errors {
  double horizontal_m = 0.0, vertical_m = 0.0, velocity_mps = 0.0;
  double largest_m = 0.0;
  std::size_t count = 0;

  void add(const Eigen::Vector3d& ned, const Eigen::Vector3d& velocity) {
    horizontal_m += ned.head<2>().squaredNorm(), vertical_m += ned.z() * ned.z();
    velocity_mps += velocity.squaredNorm();
    largest_m = std::max(largest_m, ned.norm());
    ++count;
  }
  void finish() {
    for (double* value : {&horizontal_m, &vertical_m, &velocity_mps})
      *value = std::sqrt(*value / static_cast<double>(count));
  }
};

/// The simulator's antenna track: 10 Hz from 36000 s of week 2244.
struct Truth {
  std::map<std::int64_t, std::pair<Geodetic, Eigen::Vector3d>> at_ms;
};

Truth spirent_truth() {
  Truth truth;
  const auto content =
      io::read_file(testing::recording(kSpirent + "Rover-dynamic_motion_Spirent.csv.gz"));
  EXPECT_TRUE(content);
  if (!content) return truth;
  const std::string& text = content->bytes;
  std::size_t line = text.find('\n', text.find('\n') + 1) + 1;  // two lines of heading
  while (line < text.size()) {
    const std::size_t end = std::min(text.find('\n', line), text.size());
    std::vector<double> v;
    for (std::size_t at = line; at < end;) {
      const std::size_t comma = std::min(text.find(',', at), end);
      v.push_back(std::stod(text.substr(at, comma - at)));
      at = comma + 1;
    }
    line = end + 1;
    if (v.size() < 31) continue;
    // Ant1_Pos and Ant1_Vel, Earth-fixed.
    const Eigen::Vector3d position(v[25], v[26], v[27]), velocity(v[28], v[29], v[30]);
    const Geodetic p = geodetic_from_ecef(position);
    truth.at_ms[static_cast<std::int64_t>(v[0])] = {p, rotation_ecef_ned(p).transpose() * velocity};
  }
  return truth;
}

Errors spirent_errors(const std::string& path, const SinglePointOptions& options) {
  const Ephemerides messages =
      messages_of({kSpirent + "RINEX_GN_Spirent.23N", kSpirent + "RINEX_EN_Spirent.23L"});
  const Truth truth = spirent_truth();
  Errors errors;
  for (const ObservationEpoch& epoch : epochs_of(path)) {
    const auto p = single_point(epoch, messages, options);
    EXPECT_TRUE(p) << p.error().to_string();
    const std::int64_t ms =
        (epoch.time - gps_time(2244, std::chrono::seconds(36000))).count() / 1'000'000;
    const auto found = truth.at_ms.find(ms);
    if (!p || found == truth.at_ms.end()) continue;
    EXPECT_TRUE(p->velocity_ned_mps);
    errors.add(ned_from_geodetic(p->position, found->second.first),
               p->velocity_ned_mps.value_or(Eigen::Vector3d::Zero()) - found->second.second);
  }
  errors.finish();
  return errors;
}

TEST(Recordings, SimulatorWithoutAtmosphereToACentimetre) {
  WAYFARE_NEEDS_RECORDING(path, kSpirent + "iono-none_tropo-none/Rover-dynamic_MO_Spirent.obs.gz");
  SinglePointOptions options;
  options.corrections.ionosphere = options.corrections.troposphere = false;
  const Errors e = spirent_errors(path, options);
  EXPECT_EQ(e.count, 601U);
  EXPECT_LT(e.largest_m, 0.01);
  EXPECT_LT(e.velocity_mps, 0.01);
}

TEST(Recordings, SimulatorWithAtmosphere) {
  WAYFARE_NEEDS_RECORDING(path, kSpirent + "iono-Klob_tropo-Saast/Rover-dynamic_MO_Spirent.obs.gz");
  const Errors e = spirent_errors(path, {});
  EXPECT_EQ(e.count, 601U);
  EXPECT_LE(e.horizontal_m, 0.37);
  EXPECT_LE(e.vertical_m, 1.05);
}

/// The seconds of week 2051 with a single point by RTKLIB 2.4.3 b34 (GPS and BeiDou, Klobuchar,
/// Saastamoinen, mask 15°) and a reference: 140 of 485.
bool rtklib_answers(std::int64_t second) {
  constexpr std::pair<int, int> kRuns[] = {
      {46817, 46819}, {46883, 46895}, {46900, 46900}, {46902, 46904}, {46907, 46911},
      {46915, 46915}, {46930, 46932}, {46934, 46934}, {46936, 46937}, {46939, 46947},
      {46949, 46949}, {46951, 46955}, {46958, 46958}, {46960, 47040}, {47073, 47076},
      {47079, 47079}, {47082, 47082}, {47084, 47084}, {47087, 47090}};
  return std::any_of(std::begin(kRuns), std::end(kRuns),
                     [&](const auto& run) { return second >= run.first && second <= run.second; });
}

TEST(Recordings, StreetsOfHongKong) {
  WAYFARE_NEEDS_RECORDING(path, "gnss/urbannav_tst/COM3_190428_124409.obs.gz");
  const Ephemerides messages =
      messages_of({"gnss/urbannav_tst/hksc1180.19n", "gnss/urbannav_tst/hksc1180.19b"});
  io::ColumnFormat columns;
  columns.columns = {"week", "tow_s", "lat_deg", "lon_deg", "h_m"};
  const auto reference =
      io::read_nav(testing::recording("gnss/urbannav_tst/groundTruth_TST.csv"), columns);
  ASSERT_TRUE(reference) << reference.error().to_string();
  const NavTrajectory& truth = reference->trajectory;

  Errors all, shared;
  SystemOffsets offsets;
  SinglePointOptions options;
  for (const ObservationEpoch& epoch : epochs_of(path)) {
    options.offsets = {};
    if (const auto alone = single_point(epoch, messages, options)) offsets.learn(*alone);
    options.offsets = offsets.all();
    const auto p = single_point(epoch, messages, options);
    if (!p) continue;
    const auto after = std::find_if(truth.begin(), truth.end(),
                                    [&](const NavState& s) { return s.time > p->instant; });
    if (after == truth.begin() || after == truth.end()) continue;
    const double w = to_seconds(p->instant - (after - 1)->time);  // they are 1 s apart
    const Eigen::Vector3d there = (1.0 - w) * ecef_from_geodetic((after - 1)->position) +
                                  w * ecef_from_geodetic(after->position);
    const Eigen::Vector3d error = ned_from_geodetic(p->position, geodetic_from_ecef(there));
    all.add(error, Eigen::Vector3d::Zero());
    const WeekTime t = week_time(gps_time(p->instant) + std::chrono::milliseconds(500));
    if (rtklib_answers(t.of_week / std::chrono::seconds(1)))
      shared.add(error, Eigen::Vector3d::Zero());
  }
  all.finish(), shared.finish();
  EXPECT_GE(all.count, 480U);
  EXPECT_EQ(shared.count, 140U);
  EXPECT_LT(shared.horizontal_m, 8.1);
  EXPECT_LT(all.horizontal_m, 22.0);
}

}  // namespace
}  // namespace wayfare
