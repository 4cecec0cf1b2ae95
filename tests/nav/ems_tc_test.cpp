// A recorded drive with a simulated unit and satellites: the demonstration set of a laboratory's
// tightly coupled filter (200 s, 100 Hz). Its ranges are exact; the noise of its description is
// added here: 0.5 m and a receiver clock 10 m ahead. There are no range rates.

#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <matio.h>

#include <wayfare/core/random.hpp>
#include <wayfare/core/se3.hpp>
#include <wayfare/eval/consistency.hpp>
#include <wayfare/eval/nav_error.hpp>
#include <wayfare/io/text_file.hpp>
#include <wayfare/nav/check_drive.hpp>
#include <wayfare/nav/gnss_ins.hpp>
#include "io/support.hpp"

namespace wayfare {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// One structure of a MATLAB file (level 5), read with matio.
class MatStruct {
 public:
  MatStruct(const std::string& path, const char* name)
      : file_(Mat_Open(path.c_str(), MAT_ACC_RDONLY), Mat_Close) {
    if (file_) variable_.reset(Mat_VarRead(file_.get(), name), Mat_VarFree);
  }
  [[nodiscard]] bool found() const { return variable_ != nullptr; }

  /// Column by column; empty if there is no such field.
  [[nodiscard]] std::vector<double> numbers(const char* field) const {
    return numbers_of(Mat_VarGetStructFieldByName(variable_.get(), field, 0));
  }
  /// Of one cell of a field that is a cell array.
  [[nodiscard]] std::vector<double> cell(const char* field, int index) const {
    return numbers_of(
        Mat_VarGetCell(Mat_VarGetStructFieldByName(variable_.get(), field, 0), index));
  }

 private:
  static std::vector<double> numbers_of(const matvar_t* v) {
    if (v == nullptr || v->class_type != MAT_C_DOUBLE) return {};
    const auto* data = static_cast<const double*>(v->data);
    return {data, data + v->nbytes / sizeof(double)};
  }

  std::shared_ptr<mat_t> file_;
  std::shared_ptr<matvar_t> variable_;
};

struct EmsDrive {
  std::vector<ImuSample> imu;
  NavTrajectory truth;
  std::vector<RangeEpoch> ranges;
};

EmsDrive to_drive(const MatStruct& mat, Rng rng) {
  const auto t = mat.numbers("time"), f = mat.numbers("accel"), w = mat.numbers("gyro");
  const auto lat = mat.numbers("lat"), lon = mat.numbers("lon"), h = mat.numbers("h");
  const auto v = mat.numbers("vel");
  const auto roll = mat.numbers("roll"), pitch = mat.numbers("pitch");
  const auto yaw = mat.numbers("heading");
  const std::size_t n = t.size();
  const auto row = [n](const std::vector<double>& m, std::size_t i) {
    return Eigen::Vector3d(m.at(i), m.at(n + i), m.at(2 * n + i));
  };
  EmsDrive drive;
  for (std::size_t i = 0; i < n; ++i) {
    const LogTime time = LogTime::from_seconds(t[i]);
    drive.imu.push_back({time, row(w, i), row(f, i)});
    drive.truth.push_back({time,
                           {Angle::radians(lat.at(i)), Angle::radians(lon.at(i)), h.at(i)},
                           row(v, i),
                           rotation_from_roll_pitch_yaw({roll.at(i), pitch.at(i), yaw.at(i)})});
  }
  for (int k = 0; k <= 200; ++k) {
    const auto x = mat.cell("sat_Px", k), y = mat.cell("sat_Py", k), z = mat.cell("sat_Pz", k);
    const auto range = mat.cell("sat_range", k);
    RangeEpoch epoch{LogTime::from_seconds(k), {}};
    for (std::size_t s = 0; s < range.size(); ++s) {
      CorrectedRange r;
      r.satellite = {GnssSystem::gps, static_cast<std::uint8_t>(s + 1)};
      r.position_ecef_m = {x.at(s), y.at(s), z.at(s)};
      r.range_m = range[s] + 10.0 + rng.normal(0.0, 0.5);
      r.range_sigma_m = 0.5;
      epoch.satellites.push_back(r);
    }
    drive.ranges.push_back(epoch);
  }
  return drive;
}

/// The set's unit: constant biases of 0.2 to 0.6 °/s and 0.1 to 0.3 m/s², noise of 0.1 °/s and
/// 0.029 m/s² per reading.
GnssInsOptions ems_options() {
  GnssInsOptions o;
  o.imu.gyro_white_rad_per_sqrt_s.setConstant(0.1 * kDegree * 0.1);
  o.imu.accel_white_mps_per_sqrt_s.setConstant(0.029 * 0.1);
  o.imu.gyro_bias_radps = {Eigen::Vector3d::Constant(0.4 * kDegree),
                           Eigen::Vector3d::Constant(1e6)};
  o.imu.accel_bias_mps2 = {Eigen::Vector3d::Constant(0.2), Eigen::Vector3d::Constant(1e6)};
  o.imu.gyro_scale.sigma.setConstant(1e-4);
  o.imu.accel_scale.sigma.setConstant(1e-4);
  o.clock = {0.01, 0.001};
  return o;
}

class EmsTc : public ::testing::Test {
 protected:
  void SetUp() override {
    WAYFARE_NEEDS_RECORDING(packed, "gnss/ems_tc/ems_data_TC.mat.gz");
    const auto content = io::read_file(packed);
    ASSERT_TRUE(content) << content.error().to_string();
    ASSERT_TRUE(io::write_file(path_, content->bytes));
  }

  testing::TemporaryFolder folder_;
  std::string path_ = folder_ / "ems_data_TC.mat";
};

TEST_F(EmsTc, ErrorsStayWithinThreeSigma) {
  const MatStruct mat(path_, "ems_data");
  ASSERT_TRUE(mat.found());
  const EmsDrive drive = to_drive(mat, Rng(1));
  ASSERT_EQ(drive.imu.size(), 20001U);
  ASSERT_GE(drive.ranges[0].satellites.size(), 5U);

  Rng rng(2);
  GnssInsRecording recording{drive.imu, drive.ranges, {}, GnssInsStart{}};
  GnssInsStart& start = *recording.start;
  start.nav = drive.truth[0];
  start.nav.position = geodetic_from_ned({3.0, -2.0, 4.0}, start.nav.position);
  start.nav.q_nb = SO3d::exp({0.01, -0.02, 0.08}) * start.nav.q_nb;
  const auto result = run_gnss_ins(recording, ems_options());
  ASSERT_TRUE(result) << result.error().to_string();

  // Errors of position, velocity and attitude from 20 s on, when the biases have converged.
  eval::SigmaCount<9> within;
  Eigen::Matrix<double, 9, 1> squares = Eigen::Matrix<double, 9, 1>::Zero();
  double yaw_variance = 0.0;
  for (const GnssInsPoint& p : result->points) {
    const auto i = static_cast<std::size_t>(std::lround(100.0 * p.nav.time.seconds()));
    if (i < 2000 || i >= drive.truth.size()) continue;
    const eval::NavError e = eval::nav_error(p.nav, drive.truth[i]);
    Eigen::Matrix<double, 9, 1> error;
    error << e.position_ned_m, e.velocity_ned_mps, e.attitude_body_rad;
    within.add(error, p.sigma.head<9>().cast<double>());
    squares += error.cwiseAbs2();
    yaw_variance += static_cast<double>(p.sigma[8]) * static_cast<double>(p.sigma[8]);
  }
  const Eigen::Matrix<double, 9, 1> rmse =
      (squares / static_cast<double>(within.count())).cwiseSqrt();
  RecordProperty("rmse_horizontal_m", std::to_string(std::hypot(rmse[0], rmse[1])));
  RecordProperty("rmse_down_m", std::to_string(rmse[2]));
  RecordProperty("rmse_yaw_deg", std::to_string(rmse[8] / kDegree));
  const double yaw_sigma = std::sqrt(yaw_variance / static_cast<double>(within.count()));
  RecordProperty("sigma_yaw_deg", std::to_string(yaw_sigma / kDegree));
  RecordProperty("within_3_sigma", std::to_string(within.share(3).mean()));
  ASSERT_GT(within.count(), 17000U);
  EXPECT_LT(rmse.head<2>().norm(), 0.6);
  EXPECT_LT(rmse[2], 1.0);
  EXPECT_LT(rmse.segment<3>(3).norm(), 0.2);
  // Without rates yaw is only observable in turns: σ is 0.9 degrees. Its error persists for
  // minutes, so one run is one sample: within two σ.
  EXPECT_LT(yaw_sigma, 1.0 * kDegree);
  EXPECT_LT(rmse[8], 2.0 * yaw_sigma);
  // One run with correlated errors: a component may leave its bounds for a while.
  EXPECT_GT(within.share(3).mean(), 0.98);
  EXPECT_GT(within.share(3).minCoeff(), 0.9);

  // The simulated biases.
  const auto& last = result->points.back().imu_errors;
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(last[i], 0.2 * (i + 1) * kDegree, 0.02 * kDegree);
    EXPECT_NEAR(last[3 + i], 0.1 * (i + 1), 0.05);
  }
}

// The same without a start: neither velocities nor a given heading.
TEST_F(EmsTc, StartsFromCodeOnlyRanges) {
  const MatStruct mat(path_, "ems_data");
  ASSERT_TRUE(mat.found());
  const EmsDrive drive = to_drive(mat, Rng(3));
  const GnssInsRecording recording{drive.imu, drive.ranges, {}, {}};
  for (const DriveFinding& f : check_drive(recording, ems_options()).findings)
    EXPECT_EQ(f.cause, DriveFinding::Cause::no_velocity) << f.text;
  const auto result = run_gnss_ins(recording, ems_options());
  ASSERT_TRUE(result) << result.error().to_string();
  EXPECT_THAT(check_run(recording, *result), ::testing::IsEmpty());
  eval::SigmaCount<9> within;
  for (const GnssInsPoint& p : result->points) {
    const auto i = static_cast<std::size_t>(std::lround(100.0 * p.nav.time.seconds()));
    if (i >= drive.truth.size()) continue;
    const eval::NavError e = eval::nav_error(p.nav, drive.truth[i]);
    Eigen::Matrix<double, 9, 1> error;
    error << e.position_ned_m, e.velocity_ned_mps, e.attitude_body_rad;
    within.add(error, p.sigma.head<9>().cast<double>());
  }
  RecordProperty("started_s", std::to_string(result->points.front().nav.time.seconds()));
  RecordProperty("within_3_sigma", std::to_string(within.share(3).mean()));
  ASSERT_GT(within.count(), 15000U);
  EXPECT_GT(within.share(3).mean(), 0.97);
}

}  // namespace
}  // namespace wayfare
